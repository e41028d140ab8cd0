// Contact where steps are hard to solve: obstacles that carry a body far in an equilibrium, and impacts of
// quadratic elements.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/obstacles.h"
#include "support/rules.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

class CarriedBody : public testing::TestWithParam<double> {};

// A block lies on a plate that goes up or down by a multiple of the block's size. It goes along, and is in the same
// equilibrium as without the way: there is no limit point, and no place where nothing holds it.
TEST_P(CarriedBody, GoesAlongWithItsObstacle) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {3, 3, 3}}, elastic(5e4, 0.3));
  scene.environment = gravity(9.81);
  scene.fix.push_back(fix(SelectVertices{{0}}, {true, false, true}));
  scene.fix.push_back(fix(SelectNearest{{0.2, 0.0, 0.0}}, {false, false, true}));
  scene.obstacle.push_back(plane_obstacle("plate", {0.0, -0.004, 0.0}));
  const FinishedEquilibrium at_rest(scene, mesh_of(scene));
  scene.obstacle[0].offset = {0.0, GetParam(), 0.0};
  const FinishedEquilibrium carried(scene, mesh_of(scene));
  EXPECT_TRUE(carried.load_path()->limit_points.empty());
  const Vector moved = carried.state().position - at_rest.state().position;
  for (Index v = 0; v < moved.size() / 3; ++v) {
    EXPECT_LT((vertex_block(moved, v) - scene.obstacle[0].offset).norm(), 1e-9) << v;
  }
}

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
INSTANTIATE_TEST_SUITE_P(Ways, CarriedBody, testing::Values(5.0, -1.0, 0.3));

}  // namespace
}  // namespace tetraction
