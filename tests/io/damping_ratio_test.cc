// [damping] ratio: from a scene file to the numbers, and back.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "support/temporary_folder.h"
#include "tetraction/dynamics/terms/rayleigh_damping.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

constexpr const char* kBody = R"(
[mesh]
generate = { kind = "box", size = [1, 1, 1], cells = [1, 1, 1] }
[material]
youngs_modulus = 3.0e6
poissons_ratio = 0.31
)";

class DampingRatioKeys : public testing::Test {
 protected:
  Scene read(const std::string& text) const {
    const std::string path = file("scene");
    std::ofstream(path) << kBody << text;
    return read_scene(path);
  }
  std::string file(const std::string& name) const {
    return (temporary_.path() / (name + ".toml")).string();
  }

 private:
  testing_support::TemporaryFolder temporary_;
};

TEST_F(DampingRatioKeys, BecomeMassDampingAndViscosity) {
  const Scene scene =
      read("[damping]\ndrag = 0.5\nratio = { at = [12.5, 310], value = [0.013, 0.027] }\n");
  const Damping expected = rayleigh_damping({{12.5, 310.0}, {0.013, 0.027}},
                                            initial_lame(make_material(scene.material)));
  EXPECT_EQ(scene.damping.drag, 0.5);
  EXPECT_EQ(scene.damping.mass_damping, expected.mass_damping);
  EXPECT_EQ(scene.damping.viscosity, expected.viscosity);
  ASSERT_TRUE(scene.damping_ratio);
  EXPECT_EQ(*scene.damping_ratio, (DampingRatio{{12.5, 310.0}, {0.013, 0.027}}));
}

// A scene that is written has the two numbers, which are read back bitwise.
TEST_F(DampingRatioKeys, AreWrittenAsTheTwoNumbers) {
  const Scene scene = read("[damping]\nratio = { at = [12.5, 310], value = [0.013, 0.027] }\n");
  const std::string path = file("numbers");
  write_scene(scene, path);
  const Scene again = read_scene(path);
  EXPECT_EQ(again.damping.mass_damping, scene.damping.mass_damping);
  EXPECT_EQ(again.damping.viscosity, scene.damping.viscosity);
  EXPECT_FALSE(again.damping_ratio);
  EXPECT_EQ(again.echo, scene.echo);
}

TEST_F(DampingRatioKeys, EventsUseTheMaterialOfTheirTime) {
  const Scene scene = read(R"(
[damping]
ratio = { at = [12.5, 310], value = [0.013, 0.027] }
[[event]]
at = 0.1
set = { "material.youngs_modulus" = 6.0e6 }
[[event]]
at = 0.2
set = { "damping.drag" = 0.1 }
[[event]]
at = 0.3
unset = ["damping.ratio"]
set = { "damping.viscosity" = 3.0 }
)");
  ASSERT_EQ(scene.event.size(), 3U);
  const auto damping = [&](std::size_t i) {
    return std::get<SetDamping>(scene.event[i].edits.front()).settings;
  };
  ASSERT_EQ(scene.event[0].edits.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<SetMaterial>(scene.event[0].edits.front()));
  EXPECT_EQ(damping(1).drag, 0.1);
  EXPECT_EQ(damping(1).mass_damping, scene.damping.mass_damping);
  EXPECT_DOUBLE_EQ(damping(1).viscosity, 2.0 * scene.damping.viscosity);
  EXPECT_EQ(damping(2).mass_damping, 0.0);
  EXPECT_EQ(damping(2).viscosity, 3.0);
}

}  // namespace
}  // namespace tetraction
