// The keys of Gent's law in scenes.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/messages.h"
#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

class GentScene : public testing::Test {
 protected:
  Scene scene(const std::string& parameters) {
    const std::string path = (temporary_.path() / "scene.toml").string();
    write_text_file(path, "[mesh]\nfile = \"mesh.vtu\"\n[material]\nmodel = \"gent\"\n" +
                              parameters + "[time]\nstep = 1e-3\nend = 0.01\n");
    return read_scene(path);
  }
  void expect_refusal(const std::string& parameters, const std::string& key,
                      const std::string& reason) {
    testing_support::expect_error([&] { scene(parameters); }, {key, reason});
  }

  testing_support::TemporaryFolder temporary_;
};

TEST_F(GentScene, GivesTheLaw) {
  const Gent own =
      std::get<Gent>(make_material(scene("mu = 2.7e5\njm = 86\nkappa = 1e7\n").material));
  EXPECT_EQ(own.mu(), 2.7e5);
  EXPECT_EQ(own.jm(), 86.0);
  EXPECT_EQ(own.kappa(), 1e7);
  const Gent by_young = std::get<Gent>(
      make_material(scene("youngs_modulus = 1e6\npoissons_ratio = 0.45\njm = 50\n").material));
  EXPECT_NEAR(by_young.mu(), 1e6 / 2.9, 1e-6);
  EXPECT_NEAR(by_young.kappa(), 1e6 / 0.3, 1e-6);
  EXPECT_EQ(by_young.jm(), 50.0);
}

TEST_F(GentScene, RefusesWrongParameters) {
  expect_refusal("mu = 1\njm = 0\nkappa = 1\n", "material.jm", "1e-08 or more");
  expect_refusal("mu = 1\njm = -2\nkappa = 1\n", "material.jm", "1e-08 or more");
  expect_refusal("mu = 1\njm = 9e-11\nkappa = 1\n", "material.jm", "round-off");
  expect_refusal("mu = -1\njm = 2\nkappa = 1\n", "material.mu", "above 0");
  expect_refusal("mu = 1\nkappa = 1\n", "material.jm", "is missing");
  expect_refusal("mu = [1]\njm = 2\nkappa = 1\n", "material.mu", "gent");
}

}  // namespace
}  // namespace tetraction
