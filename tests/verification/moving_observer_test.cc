// The work of moving obstacles: the energy error of a rule is the same for every observer in uniform motion, and the
// work of an obstacle that turns is that of its moment.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"

namespace tetraction {
namespace {

using namespace testing_support;

ObstacleSettings box_below() {
  ObstacleSettings box;
  box.name = "box";
  box.kind = ObstacleKind::kBox;
  box.min = {0.03, -0.4, -0.3};
  box.max = {0.6, -0.03, 0.13};
  return box;
}

ObstacleSettings mesh_below() {
  ObstacleSettings mesh = box_below();
  mesh.name = "mesh";
  mesh.kind = ObstacleKind::kMesh;
  MeshShape roof;
  roof.points = {{-0.3, -0.08, -0.3},
                 {0.5, -0.08, -0.3},
                 {0.1, -0.03, 0.1},
                 {0.5, -0.08, 0.5},
                 {-0.3, -0.08, 0.5}};
  roof.triangles = {{0, 2, 1}, {1, 2, 3}, {3, 2, 4}, {4, 2, 0}};
  mesh.surface = std::make_shared<const MeshShape>(roof);
  return mesh;
}

struct ObserverCase {
  std::string name;
  ObstacleSettings obstacle;
};

std::vector<ObserverCase> observer_cases() {
  return {{"plane", plane_obstacle("plane", {0.0, -0.03, 0.0}, {0.1, 1.0, 0.2})},
          {"sphere", sphere_obstacle("sphere", {0.12, -0.33, 0.09}, 0.3)},
          {"room", room_obstacle("room", {-0.06, -0.03, -0.05}, {0.26, 0.26, 0.25})},
          {"box", box_below()},
          {"mesh", mesh_below()}};
}

using ObserverParameters = std::tuple<Integrator, ObserverCase>;

class MovingObserver : public testing::TestWithParam<ObserverParameters> {
 protected:
  // A cube that falls onto an obstacle, seen by an observer who moves with −V.
  static Scene scene_seen(const Vector3& velocity, double friction, bool turns) {
    const Integrator rule = std::get<0>(GetParam());
    const double step = is_implicit(rule) ? 2e-3 : 2e-4;
    Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {2, 2, 2}}, elastic(5e4, 0.3));
    scene.time = {rule, step, false, 0.08};
    scene.solver.tolerance = 1e-13;
    scene.environment = gravity(9.81);
    scene.initial.velocity = Vector3(0.4, -1.0, 0.1) + velocity;
    scene.initial.angular_velocity = {1.0, 0.5, 3.0};
    ObstacleSettings obstacle = std::get<1>(GetParam()).obstacle;
    obstacle.velocity += velocity;
    obstacle.friction = friction;
    if (turns) obstacle.angular_velocity = {0.2, 1.0, -0.3};
    scene.obstacle.push_back(obstacle);
    return scene;
  }
  static std::vector<double> energy_errors(const Scene& scene) {
    Session session(scene, mesh_of(scene));
    std::vector<double> errors;
    double touched = present_gap(session);
    while (session.step()) {
      errors.push_back(session.balance().energy_error());
      touched = std::min(touched, present_gap(session));
    }
    EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_LT(touched, 0.01) << "it never touched";
    return errors;
  }
};

// In the frame of the obstacle an error is the integrator's own. A boost by V changes the kinetic energy by V·Δp, and so
// the work of gravity and of the obstacle has to change by V times their impulses.
TEST_P(MovingObserver, SeesTheSameEnergyError) {
  const Vector3 velocity(0.7, -0.4, 1.1);
  constexpr double kMass = 1000.0 * 0.2 * 0.2 * 0.2;
  const double scale = 0.5 * kMass * (velocity + Vector3(0.4, -1.0, 0.1)).squaredNorm();
  for (const double friction : {0.0, 0.5}) {
    for (const bool turns : {false, true}) {
      const std::vector<double> at_rest =
          energy_errors(scene_seen(Vector3::Zero(), friction, turns));
      const std::vector<double> moving = energy_errors(scene_seen(velocity, friction, turns));
      ASSERT_EQ(at_rest.size(), moving.size());
      for (std::size_t k = 0; k < moving.size(); ++k) {
        ASSERT_NEAR(moving[k], at_rest[k], 1e-10 * scale)
            << "step " << k << ", friction " << friction << (turns ? ", turning" : "");
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MovingObserver,
                         testing::Combine(testing::ValuesIn(all_rules()),
                                          testing::ValuesIn(observer_cases())),
                         [](const auto& test) {
                           std::string rule = to_string(std::get<0>(test.param));
                           std::erase(rule, '-');
                           return rule + "_" + std::get<1>(test.param).name;
                         });

class TurningObstacle : public testing::TestWithParam<Integrator> {
 protected:
  static double step() { return is_implicit(GetParam()) ? 1e-3 : 1e-4; }
  static bool takes_means() {
    return GetParam() == Integrator::kMidpoint || GetParam() == Integrator::kEnergyMomentum;
  }
  static BalanceSums sums_of(const Scene& scene) {
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return session.balance().sums();
  }
};

// A drum that turns about its axis does no work without friction, because it moves along its own surface. The rules that
// take means over steps, in which it turns by φ = 0.02, have an error of the order φ².
TEST_P(TurningObstacle, DoesNoWorkAlongItsOwnSurface) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.1, 0.1, 0.1}, {2, 2, 2}}, elastic(5e4, 0.3));
  scene.time = {GetParam(), step(), false, 0.1};
  scene.environment = gravity(9.81);
  scene.initial.velocity = {0.5, -1.0, 0.0};
  ObstacleSettings drum = cylinder_obstacle("drum", {0.05, 0.05, 0.0}, {0.0, 0.0, 1.0}, 0.09, true);
  drum.angular_velocity = {0.0, 0.0, 20.0};
  scene.obstacle.push_back(drum);
  const BalanceSums sums = sums_of(scene);
  ASSERT_EQ(sums.obstacles.size(), 1U);
  const double impulse = sums.obstacles[0].linear.norm();
  ASSERT_GT(impulse, 0.5);
  // The speed of its surface is 1.8 m/s.
  EXPECT_LT(std::abs(sums.constraint_work), (takes_means() ? 1e-6 : 1e-12) * impulse * 1.8);
}

// A plate that turns about an axis in its own plane and strikes a body. Its work is the sum of its angular impulse about
// the axis times its angular velocity, for the explicit rules and backward Euler exactly. The others take means over
// steps in which it turns by φ = 4e-3, whose error is of the order φ².
TEST_P(TurningObstacle, DoesTheWorkOfItsMoment) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.1, 0.1, 0.1}, {2, 2, 2}}, elastic(5e4, 0.3));
  scene.time = {GetParam(), step(), false, 0.05};
  ObstacleSettings plate = plane_obstacle("plate", {-0.2, -0.012, 0.0});
  plate.angular_velocity = {0.0, 0.0, 4.0};
  scene.obstacle.push_back(plate);
  const BalanceSums sums = sums_of(scene);
  ASSERT_EQ(sums.obstacles.size(), 1U);
  const ObstacleImpulse& impulse = sums.obstacles[0];
  ASSERT_GT(impulse.linear.y(), 0.1);
  const Vector3 moment = impulse.angular - plate.point.cross(impulse.linear);
  const double work = 4.0 * moment.z();
  EXPECT_NEAR(sums.constraint_work, work, (takes_means() ? 2e-5 : 1e-12) * work);
}

INSTANTIATE_TEST_SUITE_P(Rules, TurningObstacle, testing::ValuesIn(all_rules()), name_of_rule);

}  // namespace
}  // namespace tetraction
