// Obstacles of triangles: a flat one must act as a plane, and none may be passed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/rules.h"
#include "support/scene_parts.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A block that falls on a floor 5 cm below it, turning a little.
Scene falling_block(Integrator rule, double step, double end) {
  Scene scene = scene_of(elastic(5.0e4, 0.3));
  scene.environment = gravity(9.81);
  scene.time.integrator = rule;
  scene.time.step = step;
  scene.time.end = end;
  scene.initial.angular_velocity = {0.3, 0.0, 1.0};
  return scene;
}

ObstacleSettings floor_plane() {
  ObstacleSettings floor;
  floor.name = "floor";
  floor.kind = ObstacleKind::kPlane;
  floor.point = {0.0, -0.05, 0.0};
  return floor;
}

// A square of 4 m, made of n × n cells of two triangles. Some of their edges lie below the block.
ObstacleSettings floor_of_triangles(int n) {
  ObstacleSettings floor;
  floor.name = "floor";
  floor.kind = ObstacleKind::kMesh;
  MeshShape surface;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      surface.points.emplace_back(-2.0 + 4.0 * i / n, -0.05, -2.0 + 4.0 * j / n);
    }
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Index a = i * (n + 1) + j;
      surface.triangles.push_back({a, a + 1, a + n + 2});
      surface.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  floor.surface = std::make_shared<const MeshShape>(std::move(surface));
  return floor;
}

struct DropRun {
  State state;
  double drift = 0.0;
  double smallest_gap = 0.0;
  double contact_energy = 0.0;  // the largest one
  Vector3 impulse = Vector3::Zero();
};

DropRun run_with(Scene scene, const ObstacleSettings& obstacle) {
  scene.obstacle.push_back(obstacle);
  Session session(scene, generate_box({0.2, 0.2, 0.2}, {3, 3, 3}));
  DropRun run;
  run.smallest_gap = 1.0;
  while (session.step()) {
    const MechanicalSystem& system = session.system();
    const State& state = session.state();
    run.smallest_gap =
        std::min(run.smallest_gap,
                 system.contact()->smallest_gap(system.force_point(state.position, state.time)));
    run.contact_energy = std::max(run.contact_energy, session.balance().energies().of("contact"));
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  run.state = session.state();
  run.drift = session.balance().max_relative_energy_drift();
  run.impulse = session.balance().sums().obstacles.at(0).linear;
  return run;
}

class FlatMesh : public testing::TestWithParam<Integrator> {};

// In front of a flat surface the convergent sum over its triangles, edges and vertices is one distance. The two
// runs differ by round-off, which grows in the impact.
TEST_P(FlatMesh, ActsAsThePlane) {
  const bool is_explicit = !is_implicit(GetParam());
  const Scene scene = falling_block(GetParam(), is_explicit ? 2e-4 : 1e-3, 0.16);
  const DropRun plane = run_with(scene, floor_plane());
  const DropRun mesh = run_with(scene, floor_of_triangles(7));
  EXPECT_GT(plane.contact_energy, 0.01);  // it did fall on the floor
  EXPECT_GT(mesh.smallest_gap, 0.0);
  EXPECT_NEAR(plane.smallest_gap, mesh.smallest_gap, 1e-7 * plane.smallest_gap);
  EXPECT_NEAR((plane.impulse - mesh.impulse).norm(), 0.0, 1e-6 * plane.impulse.norm());
  EXPECT_LE((plane.state.position - mesh.state.position).cwiseAbs().maxCoeff(), 1e-7 * 0.2);
}

INSTANTIATE_TEST_SUITE_P(Rules, FlatMesh,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet,
                                         Integrator::kMidpoint, Integrator::kBackwardEuler,
                                         Integrator::kEnergyMomentum),
                         name_of_rule);

// The energies of a body at rest are round-off, and so is the share of them that a residual adds. That must not stop a
// body which touches nothing.
TEST(Obstacle, LetsABodyRestThatItDoesNotTouch) {
  for (const Integrator rule : all_rules()) {
    Scene scene = falling_block(rule, 1e-3, 0.02);
    scene.environment = {};
    scene.initial = {};
    scene.obstacle.push_back(floor_plane());
    scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
    Session session(scene, generate_box({0.2, 0.2, 0.2}, {3, 3, 3}));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << to_string(rule) << ": " << session.message();
  }
}

// At 300 m/s the block moves by three of its lengths in a step. No rule may find a solution beyond the plate, where the
// potential of contact is as good as before it.
TEST_P(FlatMesh, IsNotPassedInOneStep) {
  Scene scene = falling_block(GetParam(), 2e-3, 0.02);
  scene.initial.velocity = {0.0, -300.0, 0.0};
  scene.initial.angular_velocity.setZero();
  ObstacleSettings plate = floor_of_triangles(2);
  plate.name = "plate";
  scene.obstacle = {plate};
  Session session(scene, generate_box({0.2, 0.2, 0.2}, {3, 3, 3}));
  session.run();
  // The minimum of backward Euler lies before the plate and has lost the energy.
  if (GetParam() != Integrator::kBackwardEuler) {
    EXPECT_NE(session.status(), RunStatus::kFinished);
    EXPECT_NE(session.message().find("plate"), std::string::npos) << session.message();
  }
  const Vector& x = session.state().position;
  EXPECT_GT(x.reshaped(3, x.size() / 3).row(1).minCoeff(), -0.05);
}

// The corner of a box that stands on a spike touches no vertex of the body: its own vertices and edges must keep the
// two apart, and energy-momentum keeps the energy.
TEST(MeshObstacle, KeepsACornerOutOfAFace) {
  Scene scene = falling_block(Integrator::kEnergyMomentum, 1e-3, 0.2);
  scene.initial.angular_velocity.setZero();
  ObstacleSettings spike;
  spike.name = "spike";
  spike.kind = ObstacleKind::kMesh;
  const MeshShape pyramid{
      {{0.11, -0.05, 0.09}, {-0.2, -0.6, -0.2}, {0.4, -0.6, -0.2}, {0.1, -0.6, 0.5}},
      {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}};
  spike.surface = std::make_shared<const MeshShape>(pyramid);
  const DropRun run = run_with(scene, spike);
  EXPECT_GT(run.contact_energy, 1e-4);
  EXPECT_GT(run.smallest_gap, 0.0);
  EXPECT_LE(run.drift, 1e-10);
}

// A box from outside holds a block that falls on its edge.
TEST(MeshObstacle, BoxFromOutsideStopsABlock) {
  Scene scene = falling_block(Integrator::kBackwardEuler, 2e-3, 0.4);
  scene.initial.angular_velocity.setZero();
  ObstacleSettings step;
  step.name = "step";
  step.kind = ObstacleKind::kBox;
  step.min = {-0.5, -0.4, -0.5};
  step.max = {0.12, -0.05, 0.7};
  const DropRun run = run_with(scene, step);
  EXPECT_GT(run.contact_energy, 1e-4);
  EXPECT_GT(run.smallest_gap, 0.0);
  EXPECT_GT(run.impulse.y(), 0.0);
}

}  // namespace
}  // namespace tetraction
