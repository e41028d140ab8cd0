// What contact keeps: the energy and both momenta of a step of any size, with friction and with obstacles that move,
// and the same bits after a checkpoint and with any number of threads.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"
#include "support/same_run.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A soft cube of 0.2 m that flies and spins.
Scene flying_cube(Integrator rule, double step, double end) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {2, 2, 2}}, elastic(5e4, 0.3));
  scene.time = {rule, step, false, end};
  scene.environment = gravity(9.81);
  scene.initial.velocity = {0.4, -1.0, 0.1};
  scene.initial.angular_velocity = {1.0, 0.5, 3.0};
  return scene;
}

struct ObstacleCase {
  std::string name;
  std::vector<ObstacleSettings> obstacles;
  double largest_step = 20.0;  // as a multiple of the limit of explicit steps
};

std::vector<ObstacleCase> obstacle_cases() {
  ObstacleSettings piston = plane_obstacle("piston", {0.0, -0.05, 0.0});
  piston.velocity = {0.05, 0.1, 0.0};
  ObstacleSettings drum = cylinder_obstacle("drum", {0.1, 0.1, 0.1}, {0.0, 0.0, 1.0}, 0.18, true);
  drum.angular_velocity = {0.0, 0.0, 8.0};
  ObstacleSettings shaken = room_obstacle("room", {-0.06, -0.05, -0.05}, {0.26, 0.26, 0.25});
  shaken.velocity = {0.3, 0.5, 0.2};
  shaken.angular_velocity = {1.0, -2.0, 3.0};
  return {{"plane", {plane_obstacle("floor", {0.0, -0.04, 0.0})}},
          {"piston_and_lid", {piston, plane_obstacle("lid", {0.0, 0.26, 0.0}, {0.0, -1.0, 0.0})}},
          {"ball", {sphere_obstacle("ball", {0.13, -0.35, 0.1}, 0.31)}},
          {"drum_that_turns", {drum}, 1.0},
          {"room_that_moves", {shaken}}};
}

class ContactEnergy : public testing::TestWithParam<ObstacleCase> {};

TEST_P(ContactEnergy, IsKeptAtAnyStep) {
  for (const double friction : {0.0, 0.5}) {
    Scene scene = flying_cube(Integrator::kEnergyMomentum, 1e-3, 1.0);
    scene.obstacle = GetParam().obstacles;
    for (ObstacleSettings& obstacle : scene.obstacle) obstacle.friction = friction;
    const double limit = Session(scene, mesh_of(scene)).initial_limit().critical_step;
    for (const auto& [times, steps] : {std::pair{0.25, 160}, {1.0, 60}, {4.0, 25}, {20.0, 8}}) {
      if (times > GetParam().largest_step) continue;
      scene.time.step = times * limit;
      scene.time.end = steps * scene.time.step;
      Session session(scene, mesh_of(scene));
      const double gap = run_beside_obstacles(session);
      const std::string where = GetParam().name + ", friction " + std::to_string(friction) + ", " +
                                std::to_string(times) + " times the limit";
      EXPECT_LT(gap, 0.01) << where << ": it never touched";
      const Balance& balance = session.balance();
      EXPECT_LT(balance.max_relative_energy_drift(), 1e-11) << where;
      EXPECT_LT(balance.linear_momentum_drift(), 1e-12) << where;
      EXPECT_LT(balance.angular_momentum_drift(), 1e-10) << where;
      EXPECT_EQ(balance.friction_dissipation() > 0.0, friction > 0.0) << where;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Obstacles, ContactEnergy, testing::ValuesIn(obstacle_cases()),
                         [](const auto& test) { return test.param.name; });

class ContactBalance : public testing::TestWithParam<Integrator> {
 protected:
  static bool is_euler() { return GetParam() == Integrator::kBackwardEuler; }
  static double step() { return is_implicit(GetParam()) ? 2e-3 : 2e-4; }
};

// The momenta change by the impulses of obstacles, of gravity and of nothing else, with friction. The work of an
// obstacle that translates is its impulse times its velocity.
TEST_P(ContactBalance, HasTheImpulsesAndTheWorkOfObstacles) {
  Scene scene = flying_cube(GetParam(), step(), 0.12);
  ObstacleSettings belt = plane_obstacle("belt", {0.0, -0.03, 0.0});
  belt.velocity = {-0.8, 0.3, 0.2};
  belt.friction = 0.6;
  scene.obstacle.push_back(belt);
  scene.obstacle.push_back(plane_obstacle("far", {0.0, -9.0, 0.0}));
  Session session(scene, mesh_of(scene));
  run_beside_obstacles(session);
  const Balance& balance = session.balance();
  EXPECT_LT(balance.linear_momentum_drift(), is_euler() ? 1e-7 : 1e-12);
  if (!is_euler()) {
    EXPECT_LT(balance.angular_momentum_drift(), 1e-9);
  }
  EXPECT_GT(balance.friction_dissipation(), 0.05);
  const std::vector<ObstacleImpulse>& obstacles = balance.sums().obstacles;
  ASSERT_EQ(obstacles.size(), 2U);
  EXPECT_TRUE(obstacles[1].linear.isZero(0.0));
  const Vector3 impulse = obstacles[0].linear;
  EXPECT_GT(impulse.y(), 8.0);
  EXPECT_LT(impulse.x(), -0.5);
  EXPECT_GT(obstacles[0].largest_force, impulse.norm() / 0.12);
  const Momenta& start = balance.sums().initial_momenta;
  const Momenta& end = balance.momenta();
  const double mass = session.system().mass().sum();
  const Vector3 gravity_impulse(0.0, -9.81 * mass * session.time(), 0.0);
  const double scale = start.linear_scale + impulse.norm();
  EXPECT_LT((end.linear - start.linear - impulse - gravity_impulse).norm(),
            (is_euler() ? 1e-7 : 1e-12) * scale);
  const double work = impulse.dot(belt.velocity);
  EXPECT_NEAR(balance.constraint_work(), work, 1e-11 * std::abs(work));
}

// Two sessions in the middle of an impact with friction: the one that made a checkpoint and the one that is restored.
TEST_P(ContactBalance, GoesOnFromACheckpointWithTheSameBits) {
  Scene scene = flying_cube(GetParam(), step(), 0.1);
  scene.obstacle = obstacle_cases()[4].obstacles;
  scene.obstacle[0].friction = 0.4;
  Session continued(scene, mesh_of(scene));
  while (!(present_gap(continued) < 8e-3)) ASSERT_TRUE(continued.step()) << continued.message();
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(continued.step()) << continued.message();
  ASSERT_LT(continued.time(), 0.08);
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  expect_same(continued, restored);
  while (continued.step()) {
    ASSERT_TRUE(restored.step()) << restored.message();
    ASSERT_EQ(continued.state().position, restored.state().position) << continued.step_number();
  }
  EXPECT_FALSE(restored.step());
  EXPECT_EQ(continued.status(), RunStatus::kFinished) << continued.message();
  EXPECT_GT(continued.balance().friction_dissipation(), 0.0);
  expect_same(continued, restored);
}

class ContactThreads : public ContactBalance {
 protected:
  ~ContactThreads() override { set_thread_count(0); }
};

// A surface with more vertices than a piece of the loops over them, which begins within the layer.
TEST_P(ContactThreads, HasTheSameBitsWithAnyNumberOfThreads) {
  Scene scene = flying_cube(GetParam(), is_implicit(GetParam()) ? 1e-3 : 1e-4, 0.0);
  scene.mesh.generate->cells = {11, 11, 11};
  scene.time.end = (is_implicit(GetParam()) ? 2.0 : 20.0) * scene.time.step;
  ObstacleSettings drum = cylinder_obstacle("drum", {0.1, 0.1, 0.1}, {0.0, 0.0, 1.0}, 0.1432, true);
  drum.friction = 0.3;
  drum.angular_velocity = {0.0, 0.0, 8.0};
  drum.thickness = 2e-3;
  scene.obstacle = {drum, plane_obstacle("floor", {0.0, -1e-3, 0.0})};
  State first;
  std::vector<double> balance;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const std::vector<double> sums = numbers_of(session.balance().sums());
    if (threads == 1) {
      first = session.state();
      balance = sums;
      EXPECT_GT(session.balance().friction_dissipation(), 0.0);
      continue;
    }
    EXPECT_EQ(session.state().position, first.position);
    EXPECT_EQ(session.state().momentum, first.momentum);
    EXPECT_EQ(sums, balance);
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, ContactBalance, testing::ValuesIn(all_rules()), name_of_rule);
INSTANTIATE_TEST_SUITE_P(Rules, ContactThreads, testing::ValuesIn(all_rules()), name_of_rule);

}  // namespace
}  // namespace tetraction
