// The steps of runs beside obstacles: automatic ones, and failures that name the obstacle.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "simulation/facts/free_motions.h"
#include "support/obstacles.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A soft cube of 0.2 m that falls from the height of 0.3 m on one of its edges, 0.1 m to the side.
Scene falling_cube(Integrator rule) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {3, 3, 3}}, elastic(1e5, 0.4));
  scene.time = {rule, 1e-3, true, 0.5};
  scene.environment = gravity(9.81);
  scene.initial.angular_velocity = {0.0, 0.0, 3.0};
  return scene;
}

class AutomaticStepsOf : public testing::TestWithParam<Integrator> {};

// An obstacle that the body does not reach costs no steps, however far away and however fast the body falls.
TEST_P(AutomaticStepsOf, DoNotSeeWhatIsFarAway) {
  Scene scene = falling_cube(GetParam());
  scene.time.end = 0.2;
  const FinishedRun alone(scene);
  scene.obstacle.push_back(plane_obstacle("far", {0.0, -1e6, 0.0}));
  scene.obstacle.push_back(plane_obstacle("near", {0.0, -0.3, 0.0}));
  const FinishedRun beside(scene);
  EXPECT_EQ(beside.step_number(), alone.step_number());
  EXPECT_LT((beside.state().position - alone.state().position).norm(), 1e-12);
}

// Falls at v, with v/c up to a half. The energy error of the impacts is that of the steps in flight, about (h ω)²/8 of
// the vibrations, or less than a hundredth; the rule of order one has a few hundredths.
TEST_P(AutomaticStepsOf, AreShortEnoughForAnImpact) {
  for (const double speed : {0.0, 2.0, 7.0}) {
    Scene scene = falling_cube(GetParam());
    scene.initial.velocity = {0.4, -speed, 0.0};
    scene.obstacle.push_back(plane_obstacle("floor", {0.0, -0.3, 0.0}));
    const FinishedRun with_floor(scene);
    const double error = with_floor.balance().max_relative_energy_drift();
    EXPECT_LT(error, GetParam() == Integrator::kVerlet ? 0.01 : 0.05) << speed;
    EXPECT_GT(with_floor.balance().sums().obstacles[0].linear.y(), 1.0) << speed;
    // As few as that: the impact takes a small part of the time.
    scene.obstacle.clear();
    const FinishedRun alone(scene);
    EXPECT_LT(with_floor.step_number(), 12 * alone.step_number()) << speed;
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, AutomaticStepsOf,
                         testing::Values(Integrator::kVerlet, Integrator::kExplicit), name_of_rule);

// The message of a run that must fail, which leaves the state before the step.
std::string message_of_failure(const Scene& scene) {
  Session session(scene, mesh_of(scene));
  double gap = 1.0;
  while (session.step()) gap = present_gap(session);
  EXPECT_TRUE(session.status() == RunStatus::kUnstable ||
              session.status() == RunStatus::kNotConverged);
  EXPECT_GT(gap, 0.0);
  EXPECT_GT(present_gap(session), 0.0);
  EXPECT_TRUE(session.state().position.allFinite());
  return session.message();
}

class ObstacleFailuresOf : public testing::TestWithParam<Integrator> {
 protected:
  static Scene cube() {
    Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {2, 2, 2}}, elastic(5e4, 0.3));
    scene.time = {GetParam(), is_implicit(GetParam()) ? 1e-3 : 1e-4, false, 0.2};
    return scene;
  }
};

// The vertices of the upper face are led through a plate that is at rest, or hold still while a plate comes.
TEST_P(ObstacleFailuresOf, NameWhatCannotGiveWay) {
  for (const bool plate_moves : {false, true}) {
    Scene scene = cube();
    FixSettings held = fix(SelectFaces{{0.0, 1.0, 0.0}, {}});
    ObstacleSettings plate = plane_obstacle("plate", {0.0, 0.25, 0.0}, {0.0, -1.0, 0.0});
    // No step ends with a vertex exactly on the plate.
    (plate_moves ? plate.velocity : held.velocity) = {0.0, plate_moves ? -0.513 : 0.513, 0.0};
    scene.fix.push_back(held);
    scene.obstacle.push_back(plate);
    const std::string message = message_of_failure(scene);
    EXPECT_NE(message.find("cannot give way to the obstacle \"plate\""), std::string::npos)
        << message;
    EXPECT_NE(message.find("select"), std::string::npos) << message;
  }
}

// A plate that moves by ten elements in a step.
TEST_P(ObstacleFailuresOf, NameAnObstacleThatIsTooFast) {
  Scene scene = cube();
  ObstacleSettings plate = plane_obstacle("hammer", {0.0, -0.3, 0.0});
  plate.velocity = {0.0, 1.0 / scene.time.step, 0.0};
  scene.obstacle.push_back(plate);
  const std::string message = message_of_failure(scene);
  EXPECT_NE(message.find("the obstacle \"hammer\" moves by 1 m in this step"), std::string::npos)
      << message;
  EXPECT_NE(message.find("time.step of "), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(Rules, ObstacleFailuresOf, testing::ValuesIn(all_rules()), name_of_rule);

// Explicit steps that jump over the floor name it, with a step that would do.
TEST(ObstacleFailures, NameTheObstacleThatAnExplicitStepWouldPass) {
  Scene scene = falling_cube(Integrator::kVerlet);
  scene.time = {Integrator::kVerlet, 1e-3, false, 0.5};
  scene.initial.velocity = {0.0, -40.0, 0.0};
  scene.obstacle.push_back(plane_obstacle("floor", {0.0, -0.3, 0.0}));
  const std::string message = message_of_failure(scene);
  EXPECT_NE(message.find("obstacle \"floor\""), std::string::npos) << message;
  EXPECT_NE(message.find("time.step of "), std::string::npos) << message;
}

// Only what touches a floor is held by it.
TEST(ObstacleFacts, FreeMotionsAreThoseBesideWhatTheBodyTouches) {
  for (const double gap : {0.5, 1e-3}) {
    Scene scene = falling_cube(Integrator::kVerlet);
    scene.obstacle.push_back(plane_obstacle("floor", {0.0, -gap, 0.0}));
    const auto system = make_system(scene, mesh_of(scene));
    EXPECT_EQ(find_free_motions(*system, 0.0, Contact::Support::kPossible).whole.size(), 3U);
    EXPECT_EQ(find_free_motions(*system, 0.0, Contact::Support::kPresent).whole.size(),
              gap > 0.1 ? 6U : 3U);
  }
}

// A body that lies loose in a wide room has no definite place, and the message says what it can do.
TEST(ObstacleFailures, SayThatABodyLiesLooseInARoom) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {3, 3, 3}}, elastic(5e4, 0.3));
  scene.environment = gravity(9.81);
  scene.obstacle.push_back(room_obstacle("room", {-1.0, -1.0, -1.0}, {1.2, 1.2, 1.2}));
  Session session(scene, mesh_of(scene), Analysis::kEquilibrium);
  EXPECT_EQ(session.run(), RunStatus::kNotConverged);
  EXPECT_NE(session.message().find("leave it free to move along x"), std::string::npos)
      << session.message();
  EXPECT_LT(session.step_number(), 10);
}

}  // namespace
}  // namespace tetraction
