// Contact where steps are hard to solve.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/obstacles.h"
#include "support/rules.h"

namespace tetraction {
namespace {

using namespace testing_support;

class QuadraticImpact : public testing::TestWithParam<Integrator> {};

// A soft cube of ten-node tetrahedra falls on a corner, with a quarter of the speed of its pressure waves, and bounces.
// No vertex, also no corner of an element, comes near the obstacle, because its layer holds it.
TEST_P(QuadraticImpact, KeepsCornersInTheLayer) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {3, 3, 3}}, elastic(5e4, 0.3));
  const bool is_automatic = !is_implicit(GetParam());
  scene.time = {GetParam(), 1e-3, is_automatic, 0.1};
  scene.environment = gravity(9.81);
  scene.initial.velocity = {1.0, -2.0, 0.3};
  scene.initial.angular_velocity = {1.0, 2.0, 3.0};
  ObstacleSettings floor = plane_obstacle("floor", {0.0, -0.05, 0.0});
  floor.friction = 0.4;
  scene.obstacle.push_back(floor);
  Session session(scene, with_edge_vertices(mesh_of(scene)));
  const double thickness = session.system().contact()->thickness(0);
  const double gap = run_beside_obstacles(session);
  EXPECT_LT(gap, thickness);
  EXPECT_GT(gap, 0.02 * thickness);
}

INSTANTIATE_TEST_SUITE_P(Rules, QuadraticImpact, testing::ValuesIn(all_rules()), name_of_rule);

}  // namespace
}  // namespace tetraction
