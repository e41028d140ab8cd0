// Edits of obstacles between two steps.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"
#include "support/same_run.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ObstacleEdits : public testing::TestWithParam<Integrator> {
 protected:
  // A soft cube of 0.2 m that falls onto a moving plane.
  static Scene falling_cube() {
    Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {2, 2, 2}}, elastic(5e4, 0.3));
    scene.time = {GetParam(), is_implicit(GetParam()) ? 2e-3 : 2e-4, false, 0.2};
    scene.environment = gravity(9.81);
    ObstacleSettings belt = plane_obstacle("belt", {0.0, -0.03, 0.0});
    belt.velocity = {0.4, 0.2, 0.0};
    belt.friction = 0.5;
    scene.obstacle = {belt};
    return scene;
  }
  static Vector3 place(const Session& session, std::size_t number) {
    const Contact& contact = *session.system().contact();
    return frame_at(contact.obstacle(number).motion, session.time()).shift;
  }
  static void run_until(Session& session, double time) {
    while (session.time() < time - 1e-9) ASSERT_TRUE(session.step()) << session.message();
  }
};

INSTANTIATE_TEST_SUITE_P(Rules, ObstacleEdits, testing::ValuesIn(all_rules()), name_of_rule);

TEST_P(ObstacleEdits, LetObstaclesGoOnFromWhereTheyAre) {
  const Scene scene = falling_cube();
  Session session(scene, mesh_of(scene));
  run_until(session, 0.1);
  EXPECT_LT(present_gap(session), 0.01);
  ObstacleSettings belt = scene.obstacle[0];
  const Vector3 before = place(session, 0);
  EXPECT_LT((before - Vector3(0.04, 0.02, 0.0)).norm(), 1e-12);
  belt.velocity = {0.0, -0.1, 0.0};
  belt.friction = 0.1;
  session.apply(SetObstacle{0, belt});
  EXPECT_EQ(place(session, 0), before);
  EXPECT_EQ(session.edits().back().energy_jump, 0.0);
  EXPECT_EQ(session.system().contact()->obstacle(0).friction, 0.1);
  run_until(session, 0.15);
  EXPECT_LT((place(session, 0) - before - Vector3(0.0, -0.005, 0.0)).norm(), 1e-12);
  // Another friction does not begin a new motion.
  belt.friction = 0.2;
  session.apply(SetObstacle{0, belt});
  run_until(session, 0.2);
  EXPECT_LT((place(session, 0) - before - Vector3(0.0, -0.01, 0.0)).norm(), 1e-12);
  const double allowed = GetParam() == Integrator::kEnergyMomentum ? 1e-11 : 1.0;
  EXPECT_LT(session.balance().max_relative_energy_drift(), allowed);
}

TEST_P(ObstacleEdits, RemoveAnObstacleUnderLoad) {
  Scene scene = falling_cube();
  scene.obstacle.push_back(plane_obstacle("far", {0.0, -2.0, 0.0}));
  Session session(scene, mesh_of(scene));
  run_until(session, 0.1);
  const double stored = session.system().contact()->energy(
      session.system().force_point(session.state().position, session.time()));
  EXPECT_GT(stored, 0.0);
  session.apply(RemoveObstacle{0});
  EXPECT_NEAR(session.edits().back().energy_jump, -stored, 1e-9 * session.balance().energy_scale());
  EXPECT_TRUE(std::isinf(present_gap(session)));
  EXPECT_EQ(session.system().contact()->obstacle(1).name, "far");
  const double height = session.state().position[1];
  run_until(session, 0.2);
  EXPECT_LT(session.state().position[1], height);
  // It comes back with its number, and refuses a body that is beyond it.
  ObstacleSettings again = scene.obstacle[0];
  EXPECT_THROW(session.apply(SetObstacle{0, again}), InputError);
  again.point.y() = -0.8;
  session.apply(SetObstacle{0, again});
  EXPECT_FALSE(session.settings().obstacles[0].removed);
}

TEST_P(ObstacleEdits, AddObstaclesThatStandAtTheirPlaces) {
  const Scene scene = falling_cube();
  Session session(scene, mesh_of(scene));
  run_until(session, 0.1);
  ObstacleSettings lid = plane_obstacle("lid", {0.0, 0.3, 0.0}, {0.0, -1.0, 0.0});
  lid.velocity = {0.0, -0.05, 0.0};
  session.apply(SetObstacle{{}, lid});
  EXPECT_TRUE(place(session, 1).isZero(0.0));
  run_until(session, 0.15);
  EXPECT_LT((place(session, 1) - Vector3(0.0, -0.0025, 0.0)).norm(), 1e-12);
}

TEST_P(ObstacleEdits, ThatAreRefusedChangeNothing) {
  const Scene scene = falling_cube();
  Session session(scene, mesh_of(scene));
  Session other(scene, mesh_of(scene));
  run_until(session, 0.1);
  run_until(other, 0.1);
  ObstacleSettings belt = scene.obstacle[0];
  ObstacleSettings through = belt;
  through.point.y() = 0.1;
  ObstacleSettings no_normal = belt;
  no_normal.normal.setZero();
  ObstacleSettings no_amplitude = belt;
  no_amplitude.amplitude = "none";
  ObstacleSettings same_name = plane_obstacle("belt", {0.0, -1.0, 0.0});
  const ObstacleSettings wall = plane_obstacle("wall", {0.0, -1.0, 0.0});
  for (const Edit& edit :
       {Edit(SetObstacle{0, through}), Edit(SetObstacle{0, no_normal}),
        Edit(SetObstacle{0, no_amplitude}), Edit(SetObstacle{{}, same_name}),
        Edit(SetObstacle{1, wall}), Edit(SetObstacle{2, belt}), Edit(RemoveObstacle{1})}) {
    EXPECT_THROW(session.apply(edit), InputError);
    EXPECT_EQ(session.settings().obstacles.size(), 1U);
    EXPECT_EQ(session.system().contact()->size(), 1U);
  }
  run_until(session, 0.2);
  run_until(other, 0.2);
  EXPECT_EQ(session.state().position, other.state().position);
}

// A turned obstacle goes on from its angle, and the point about which it turns moves along.
TEST_P(ObstacleEdits, KeepTheAngle) {
  Scene scene = falling_cube();
  scene.environment = {};
  ObstacleSettings& drum = scene.obstacle[0];
  drum = cylinder_obstacle("drum", {0.1, 0.1, 0.1}, {0.0, 0.0, 1.0}, 0.5, true);
  drum.velocity = {0.1, 0.0, 0.0};
  drum.angular_velocity = {0.0, 0.0, 5.0};
  const ObstacleSettings at_first = drum;
  Session session(scene, mesh_of(scene));
  Session whole(scene, mesh_of(scene));
  run_until(session, 0.1);
  const auto frame = [](const Session& run) {
    return frame_at(run.system().contact()->obstacle(0).motion, run.time());
  };
  ObstacleSettings faster = at_first;
  faster.until = 0.3;  // changes nothing yet, but begins a new motion
  session.apply(SetObstacle{0, faster});
  run_until(session, 0.2);
  run_until(whole, 0.2);
  EXPECT_LT((frame(session).rotation - frame(whole).rotation).norm(), 1e-12);
  EXPECT_LT((frame(session).shift - frame(whole).shift).norm(), 1e-12);
}

TEST_P(ObstacleEdits, AreInCheckpoints) {
  const Scene scene = falling_cube();
  Session session(scene, mesh_of(scene));
  run_until(session, 0.05);
  ObstacleSettings belt = scene.obstacle[0];
  belt.velocity = {-0.3, 0.1, 0.0};
  session.apply(SetObstacle{0, belt});
  session.apply(SetObstacle{{}, plane_obstacle("wall", {-0.5, 0.0, 0.0}, {1.0, 0.0, 0.0})});
  run_until(session, 0.1);
  session.apply(RemoveObstacle{1});
  const Checkpoint checkpoint = session.checkpoint();
  Session other(scene, mesh_of(scene));
  other.restore(checkpoint);
  EXPECT_EQ(place(other, 0), place(session, 0));
  run_until(session, 0.2);
  run_until(other, 0.2);
  EXPECT_EQ(session.state().position, other.state().position);
  EXPECT_EQ(session.state().momentum, other.state().momentum);
}

TEST_P(ObstacleEdits, NeedAContact) {
  Scene scene = falling_cube();
  const ObstacleSettings belt = scene.obstacle[0];
  scene.obstacle.clear();
  Session session(scene, mesh_of(scene));
  EXPECT_THROW(session.apply(SetObstacle{{}, belt}), InputError);
  EventSettings event;
  event.at = 0.05;
  event.edits = {SetObstacle{{}, belt}};
  scene.event = {event};
  Session later(scene, mesh_of(scene));
  run_until(later, 0.2);
  EXPECT_EQ(later.system().contact()->size(), 1U);
}

// Nothing crosses the surface of the body there, and no layer is reached.
TEST(ObstaclesInside, AreRefused) {
  Scene scene = scene_of({GeneratorKind::kBox, {1.0, 1.0, 1.0}, {2, 2, 2}}, elastic(5e4, 0.3));
  ObstacleSettings box;
  box.name = "core";
  box.kind = ObstacleKind::kBox;
  box.min = {0.3, 0.3, 0.3};
  box.max = {0.4, 0.45, 0.4};
  box.thickness = 0.01;
  ObstacleSettings ball;
  ball.name = "core";
  ball.kind = ObstacleKind::kSphere;
  ball.center = {0.3, 0.25, 0.2};
  ball.radius = 0.1;
  ball.thickness = 0.01;
  for (const ObstacleSettings& core : {box, ball}) {
    scene.obstacle = {core};
    expect_error([&] { Session(scene, mesh_of(scene)); }, {"the whole obstacle \"core\"", "apart"});
  }
  // A room around the body is not inside it, and an edit is refused likewise.
  box.inside = true;
  box.min = {-0.1, -0.1, -0.1};
  box.max = {1.1, 1.1, 1.1};
  scene.obstacle = {box};
  Session session(scene, mesh_of(scene));
  ball.name = "ball";
  expect_error(
      [&] {
        session.apply(SetObstacle{std::nullopt, ball});
      },
      {"the whole obstacle \"ball\""});
  EXPECT_EQ(session.settings().obstacles.size(), 1U);
  ball.center.y() = 3.0;
  ball.name = "far";
  session.apply(SetObstacle{std::nullopt, ball});
  session.apply(RemoveObstacle{1});
  expect_error([&] { session.apply(RemoveObstacle{1}); }, {"\"far\"", "removed already"});
}

}  // namespace
}  // namespace tetraction
