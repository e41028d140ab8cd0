// The files of natural modes, and the motion of one of them.
#include "viewer/analyses/stored_modes.h"

#include <filesystem>
#include <fstream>

#include "support/temporary_folder.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mode_writer.h"
#include "tetraction/io/text_file.h"
#include "tetraction/simulation/scene_modes.h"
#include "viewer/scene/scene_editor.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

class StoredModesTest : public testing::Test {
 protected:
  StoredModesTest() {
    scene_.material = elastic(1.0e6, 0.4);
    scene_.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {1.2, 0.3, 0.2}, {4, 2, 1}};
    scene_.fix = {fix(SelectPlane{0, 0.0, {}})};
    scene_.environment = gravity(9.81);
  }
  /// Writes modes as tetraction modes does.
  std::string write(bool loaded, Index count = 3) {
    const std::string directory = folder_.path().string() + (loaded ? "/loaded" : "/rest");
    std::filesystem::create_directories(directory);
    const auto system = make_system(scene_, mesh_of(scene_));
    const PositionsOfModes at = positions_of_modes(scene_, *system, loaded, count);
    modes_ = normal_modes(*system, at.position, at.options);
    middle_ = at.position;
    write_modes(*system, at.position, modes_, directory);
    write_text_file(directory + "/summary.json",
                    modes_summary_json(*system, modes_, {}, directory, 0.0));
    return directory;
  }
  /// What StoredModes says of a directory whose file has this text.
  std::string refusal(const std::string& directory, const char* file, const std::string& text) {
    const std::string broken = folder_.path().string() + "/broken";
    std::filesystem::remove_all(broken);
    std::filesystem::copy(directory, broken, std::filesystem::copy_options::recursive);
    std::ofstream(broken + "/" + file) << text;
    try {
      StoredModes(broken).motion(0);
    } catch (const FileError& error) {
      return error.what();
    }
    return "it was read";
  }
  static double largest(const Vector& displacement) {
    return displacement.reshaped(3, displacement.size() / 3).colwise().norm().maxCoeff();
  }

  TemporaryFolder folder_;
  Scene scene_;
  NormalModes modes_;
  Vector middle_;
};

TEST_F(StoredModesTest, HaveTheNumbersOfTheFiles) {
  const StoredModes stored(write(false));
  ASSERT_EQ(stored.modes().size(), 3U);
  EXPECT_EQ(stored.mesh().vertex_count(), mesh_of(scene_).vertex_count());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(stored.modes()[i].frequency, modes_.modes[i].frequency()) << i;
    EXPECT_EQ(stored.modes()[i].kind, "elastic");
    EXPECT_NEAR((stored.modes()[i].effective_mass - mass_fractions(modes_.modes[i], modes_)).norm(),
                0.0, 1e-15);
  }
  const StudyGrid grid = grid_of_modes(stored.modes());
  ASSERT_EQ(grid.rows().size(), 3U);
  EXPECT_EQ(grid.columns()[2].head, "frequency [Hz]");
  EXPECT_DOUBLE_EQ(grid.rows()[1].cells[2].value, modes_.modes[1].frequency());
  EXPECT_DOUBLE_EQ(grid.rows()[1].cells[3].value, 1.0 / modes_.modes[1].frequency());
}

TEST_F(StoredModesTest, SwingAboutTheBodyAtRest) {
  const StoredModes stored(write(false));
  for (std::size_t i = 0; i < 3; ++i) {
    ModeMotion motion = stored.motion(i);
    motion.amplitude = 0.2;
    EXPECT_EQ(motion.middle, stored.mesh().rest_positions());
    EXPECT_NEAR(motion.diagonal, Vector3(1.2, 0.3, 0.2).norm(), 1e-12);
    EXPECT_NEAR(largest(motion.shape), 1.0, 1e-12);
    // The shape is that of the mode, with another factor.
    const Vector& shape = modes_.modes[i].shape;
    const double factor = shape.dot(motion.shape) / shape.squaredNorm();
    EXPECT_NEAR((motion.shape - factor * shape).norm(), 0.0, 1e-12 * motion.shape.norm());
    // A sine of one period.
    EXPECT_EQ(largest(motion.displacement(0.0)), 0.0);
    EXPECT_NEAR(largest(motion.displacement(0.25)), 0.2 * motion.diagonal, 1e-12);
    EXPECT_NEAR((motion.displacement(0.75) + motion.displacement(0.25)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((motion.displacement(1.0) - motion.displacement(0.0)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((motion.displacement(0.4) - motion.displacement(0.1)).norm(), 0.0, 1e-12);
  }
}

TEST_F(StoredModesTest, SwingAboutTheEquilibrium) {
  const StoredModes stored(write(true));
  const ModeMotion motion = stored.motion(0);
  EXPECT_GT((middle_ - stored.mesh().rest_positions()).norm(), 1e-4);
  EXPECT_NEAR((motion.middle - middle_).norm(), 0.0, 1e-12);
}

// The names of the files have as many digits as the largest number needs.
TEST_F(StoredModesTest, AreFoundAmongAHundred) {
  scene_.mesh.generate->cells = {5, 2, 2};
  const StoredModes stored(write(false, 100));
  ASSERT_EQ(stored.modes().size(), 100U);
  EXPECT_NEAR(largest(stored.motion(99).shape), 1.0, 1e-12);
}

TEST_F(StoredModesTest, RefuseFilesThatAreBroken) {
  const std::string good = write(false);
  const auto expect = [&](const std::string& part, const char* file, const std::string& text) {
    const std::string message = refusal(good, file, text);
    EXPECT_NE(message.find(part), std::string::npos) << message << " for " << text;
    EXPECT_NE(message.find(file), std::string::npos) << message;
  };
  for (const char* text :
       {"", "{", "[]", "{}", R"({"command": "run", "modes": [{}]})", R"({"command": "modes"})",
        R"({"command": "modes", "modes": []})", R"({"command": "modes", "modes": 3})"}) {
    expect("no summary of natural modes", "summary.json", text);
  }
  for (const char* entry :
       {"{}", "3", "null", R"({"kind": "elastic"})", R"({"kind": "elastic", "frequency": null})",
        R"({"kind": "elastic", "frequency": "nan"})", R"({"kind": 3, "frequency": 1.0})"}) {
    expect("mode 1 has no kind or no frequency", "summary.json",
           std::string(R"({"command": "modes", "modes": [)") + entry + "]}");
  }
  // JSON has no NaN: such a text is none.
  expect("no summary", "summary.json",
         R"({"command": "modes", "modes": [{"kind": "elastic", "frequency": nan}]})");
  expect("not a VTU file", "mode_01.vtu", "");
  std::filesystem::remove(good + "/mode_02.vtu");
  EXPECT_THROW(StoredModes(good).motion(1), FileError);
  EXPECT_THROW(StoredModes(folder_.path().string() + "/nothing"), FileError);
}

// A file of another body, or without a shape.
TEST_F(StoredModesTest, RefuseFilesOfAnotherBody) {
  const std::string good = write(false);
  scene_.mesh.generate->cells = {3, 2, 1};
  const std::string other = write(true);
  std::filesystem::copy(other + "/mode_02.vtu", good + "/mode_02.vtu",
                        std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(StoredModes(good).motion(1), FileError);
}

// What a scene computes from the start, with edits as if they held there.
TEST(SceneWithEdits, HasAllOfThem) {
  Scene scene = scene_of(GeneratorSettings{GeneratorKind::kBox, {1.2, 0.3, 0.2}, {4, 2, 1}},
                         elastic(1.0e6, 0.4));
  scene.time.step = 1.0e-3;
  scene.time.end = std::numeric_limits<double>::infinity();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 3);
  ForceSettings force;
  force.select = SelectAll{};
  force.vector = {0.0, 3.0, 0.0};
  simulation->edit(SetForce{{}, force}, "A force");
  MaterialSettings material = scene.material;
  material.youngs_modulus = 7.0e5;
  simulation->edit(SetMaterial{0, material}, "Softer");
  make_steps(*simulation, 2);
  const Scene edited = scene_with_edits(*simulation);
  ASSERT_EQ(edited.force.size(), scene.force.size() + 1);
  EXPECT_EQ(edited.force.back().vector, Vector3(0.0, 3.0, 0.0));
  EXPECT_EQ(edited.material.youngs_modulus, 7.0e5);
  EXPECT_TRUE(edited.event.empty());
  EXPECT_EQ(edited.time.end, TimeSettings{}.end);  // a file must have one
}

}  // namespace
}  // namespace tetraction::viewer
