// Materials whose parameters are lists: reading, messages, writing, overrides, and arrays as entries.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "support/messages.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/scene_echo.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

constexpr const char* kTreloar = "mu = [6.3e5, 1.2e3, -1e4]\nalpha = [1.3, 5, -2]\nkappa = 1e7\n";

class MaterialLists : public testing::Test {
 protected:
  void SetUp() override {
    TetMesh mesh = generate_box({1, 1, 1}, {2, 1, 1});
    Matrix modulus(1, mesh.tetrahedron_count());
    for (Index e = 0; e < modulus.cols(); ++e) modulus(0, e) = 1e5 * (1.0 + static_cast<double>(e));
    mesh.cell_arrays["M"] = modulus;
    write_mesh(mesh, path("mesh.vtu"));
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Scene scene(const std::string& material, const std::vector<std::string>& overrides = {}) {
    write_text_file(path("scene.toml"), "[mesh]\nfile = \"mesh.vtu\"\n[material]\n" + material +
                                            "[time]\nstep = 1e-3\nend = 0.01\n");
    return read_scene(path("scene.toml"), overrides);
  }
  std::string refusal(const std::string& material, const std::vector<std::string>& overrides = {}) {
    return testing_support::message_of([&] {
      const Scene read = scene(material, overrides);
      make_system(read, read_scene_mesh(read));
    });
  }
  void expect_refusal(const std::string& lines, const std::vector<std::string>& parts,
                      const std::vector<std::string>& overrides = {}) {
    const std::string message = refusal(lines, overrides);
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << part << " is not in: " << message;
    }
  }
  static std::string ogden(const std::string& lines) { return "model = \"ogden\"\n" + lines; }

  testing_support::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(MaterialLists, GiveTheTermsOfOgden) {
  const Ogden read = std::get<Ogden>(make_material(scene(ogden(kTreloar)).material));
  ASSERT_EQ(read.term_count(), 3);
  EXPECT_EQ(read.mu()[2], -1e4);
  EXPECT_EQ(read.alpha()[1], 5.0);
  EXPECT_EQ(read.kappa(), 1e7);
  const Ogden by_ratio = std::get<Ogden>(
      make_material(scene(ogden("mu = [1e5]\nalpha = [2]\npoissons_ratio = 0.45\n")).material));
  EXPECT_NEAR(by_ratio.kappa(), 2.0 * 1e5 * 1.45 / 0.3, 1e-9);
}

TEST_F(MaterialLists, EntriesHaveNames) {
  const Scene read = scene(ogden(kTreloar), {"material.mu.0=7e5", "material.alpha.2=-3"});
  const Ogden material = std::get<Ogden>(make_material(read.material));
  EXPECT_EQ(material.mu()[0], 7e5);
  EXPECT_EQ(material.mu()[1], 1.2e3);
  EXPECT_EQ(material.alpha()[2], -3.0);
  EXPECT_EQ(number_of(read.material, "mu.0"), 7e5);
}

TEST_F(MaterialLists, AreWrittenAsTheyWereRead) {
  const Scene read = scene(ogden("mu = [{ array = \"M\" }, 1e3]\nalpha = [2, 4]\nkappa = 1e7\n"));
  write_text_file(path("again.toml"), scene_text(read, folder_.string()));
  const Scene again = read_scene(path("again.toml"));
  EXPECT_EQ(again.material.numbers, read.material.numbers);
  EXPECT_EQ(again.material.arrays, read.material.arrays);
  EXPECT_NE(scene_echo(read).find("\"mu\""), std::string::npos);
}

TEST_F(MaterialLists, AnEntryCanBeAnArrayOfTheMesh) {
  const Scene read = scene(ogden("mu = [{ array = \"M\" }, 1e3]\nalpha = [2, 4]\nkappa = 1e7\n"));
  const auto body = make_system(read, read_scene_mesh(read));
  for (Index e = 0; e < body->mesh().tetrahedron_count(); ++e) {
    EXPECT_NEAR(body->lame(e).mu, 1e5 * (1.0 + static_cast<double>(e)) + 2e3, 1e-6);
  }
}

TEST_F(MaterialLists, WrongOnesAreRefused) {
  expect_refusal(ogden("mu = [1, 2]\nalpha = [2]\nkappa = 1\n"), {"mu has 2 and alpha 1"});
  expect_refusal(ogden("mu = []\nalpha = []\nkappa = 1\n"), {"material.mu", "0 entries", "1 to 8"});
  expect_refusal(ogden("mu = [1, 1, 1, 1, 1, 1, 1, 1, 1]\nalpha = [2]\nkappa = 1\n"),
                 {"material.mu", "9 entries", "1 to 8"});
  expect_refusal(ogden("mu = [-1]\nalpha = [2]\nkappa = 1\n"), {"must be positive"});
  expect_refusal(ogden("mu = [1]\nalpha = [0]\nkappa = 1\n"), {"alpha.0"});
  expect_refusal(ogden("mu = [1]\nalpha = [2]\nkappa = 0\n"), {"material.kappa", "above 0"});
  expect_refusal(ogden("mu = 1\nalpha = [2]\nkappa = 1\n"), {"material.mu", "list"});
  expect_refusal(ogden("mu = [1]\nalpha = 2\nkappa = 1\n"), {"material.alpha", "list"});
  expect_refusal(ogden("mu = [\"x\"]\nalpha = [2]\nkappa = 1\n"), {"material.mu", "numbers"});
  expect_refusal(ogden("mu = [1]\nalpha = [2]\n"), {"material.kappa is missing"});
  expect_refusal(ogden("mu = [1]\nalpha = [2]\nkappa = 1\nyoungs_modulus = 1\n"),
                 {"material.", "ogden"});
  expect_refusal("mu = [1]\nlambda = 1\n", {"material.mu", "neo-hookean"});
  expect_refusal(ogden("mu = [{ array = \"absent\" }]\nalpha = [2]\nkappa = 1\n"),
                 {"material.mu.0", "absent"});
}

}  // namespace
}  // namespace tetraction
