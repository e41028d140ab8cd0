// The scenes of examples/scenes as whole problems.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

// Every shipped scene, with the implicit rules: the same steps as Ceres'.
class ShippedScene : public testing::TestWithParam<std::tuple<std::string, Integrator>> {};

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(TETRACTION_SCENES)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST_P(ShippedScene, TheSameStepsAsCeres) {
  const auto& [name, integrator] = GetParam();
  Scene scene = read_scene(std::string(TETRACTION_SCENES) + "/" + name + ".toml");
  scene.mesh.volume = VolumeRule::kElement;  // Ceres takes no nodal volumes
  const TetMesh mesh = read_scene_mesh(scene);
  const bool bodies_touch = scene.contact.between != ContactBetween::kNone;
  if (!scene.obstacle.empty() || bodies_touch) {
    const bool rubs = std::any_of(scene.obstacle.begin(), scene.obstacle.end(),
                                  [](const ObstacleSettings& each) { return each.friction > 0.0; });
    if (rubs || bodies_touch || integrator == Integrator::kMidpoint) {
      SolverSettings ceres;
      ceres.kind = "ceres";
      EXPECT_THROW(make_stepper(integrator, ceres, *make_system(scene, mesh)), InputError);
      return;
    }
  }
  const auto system = make_system(scene, mesh);
  const State start = make_initial_state(scene, *system);
  const double h = scene.time.automatic ? 0.01 : scene.time.step;
  const int steps = mesh.tetrahedron_count() > 3000 ? 2 : 3;
  SolverSettings settings;
  settings.tolerance = 1e-10;
  settings.max_iterations = 200;
  settings.kind = "ceres";
  const auto run = [&] {
    std::vector<Vector> positions;
    State state = start;
    const auto stepper = make_stepper(integrator, settings, *system);
    for (int i = 1; i <= steps; ++i) {
      const StepOutcome outcome = stepper->step_to(state, h, i * h);
      EXPECT_TRUE(outcome.ok()) << settings.kind << " " << outcome.message;
      positions.push_back(state.position);
    }
    return positions;
  };
  const std::vector<Vector> expected = run();
  settings.kind = "newton";
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    settings.linear = linear;
    if (linear == LinearSolver::kMatrixFree && !system->coordinates().sets().empty()) continue;
    const std::vector<Vector> positions = run();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double moved = (expected[i] - start.position).norm();
      EXPECT_LE((positions[i] - expected[i]).norm(), 1e-7 * moved)
          << to_string(linear) << ", step " << i + 1;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene,
                         testing::Combine(testing::ValuesIn(shipped_scenes()),
                                          testing::Values(Integrator::kMidpoint,
                                                          Integrator::kBackwardEuler)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == Integrator::kMidpoint ? "_midpoint"
                                                                                    : "_euler");
                         });

// Lamé: u(r) = p a³/(E (b³ − a³)) ((1 − 2ν) r + (1 + ν) b³/(2 r²)).
TEST(ShippedScenes, TheThickSphereMeetsLame) {
  const Scene scene = read_scene(std::string(TETRACTION_SCENES) + "/thick_sphere.toml");
  const auto system = make_system(scene, read_scene_mesh(scene));
  make_initial_state(scene, *system);
  const Equilibrium equilibrium = find_equilibrium(*system, scene.solver);
  ASSERT_TRUE(equilibrium.found) << equilibrium.message;
  const TetMesh& mesh = system->mesh();
  for (const auto& [radius, exact] : {std::pair{1.0, 8e-4}, {2.0, 3e-4}}) {
    double sum = 0.0;
    int count = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(v)];
      if (std::abs(x.norm() - radius) > 1e-6) continue;
      sum += (vertex_block(equilibrium.position, v) - x).dot(x.normalized());
      ++count;
    }
    EXPECT_NEAR(sum / count, exact, 0.01 * exact);
  }
}

}  // namespace
}  // namespace tetraction
