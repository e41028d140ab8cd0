// Probes of the force of an obstacle and of its moment.
#include <Eigen/Geometry>

#include <string>
#include <utility>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

using namespace testing_support;

const Vector3 kNowhere(0.3, -0.7, 0.2);

// A soft cube between a floor that moves and a wall, both rough. Nothing else acts on it.
Scene cube_in_a_corner(Integrator rule) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {2, 2, 2}}, elastic(5e4, 0.3));
  scene.time = {rule, is_implicit(rule) ? 2e-3 : 2e-4, false, 0.1};
  scene.solver.tolerance = 1e-11;
  scene.initial.velocity = {-1.0, -1.5, 0.3};
  scene.initial.angular_velocity = {1.0, 0.5, 3.0};
  ObstacleSettings floor = plane_obstacle("floor", {0.0, -0.03, 0.0});
  floor.friction = 0.4;
  floor.velocity = {0.2, 0.1, 0.0};
  floor.angular_velocity = {0.0, 2.0, 0.0};
  ObstacleSettings wall = plane_obstacle("wall", {-0.04, 0.0, 0.0}, {1.0, 0.0, 0.0});
  wall.friction = 0.2;
  scene.obstacle = {floor, wall};
  using enum ProbeQuantity;
  scene.probe = {probe_on("floor", "floor"), probe_on("wall", "wall"),
                 probe_on("floor_moment", "floor", kContactMoment),
                 probe_on("wall_moment", "wall", kContactMoment),
                 probe_on("about", "wall", kContactMoment, kNowhere)};
  return scene;
}

std::vector<Vector3> values_of_probes(const Session& session) {
  std::vector<double> values(session.probes().value_count());
  session.probes().evaluate(session, values.data());
  std::vector<Vector3> vectors;
  for (std::size_t i = 0; i < values.size(); i += 3) {
    vectors.emplace_back(values[i], values[i + 1], values[i + 2]);
  }
  return vectors;
}

class ObstacleProbe : public testing::TestWithParam<Integrator> {};

// The forces of all obstacles, with friction, are the rate of the body's momentum, and their moments that of its
// angular momentum, in each step.
TEST_P(ObstacleProbe, IsTheRateOfTheMomenta) {
  Session session(cube_in_a_corner(GetParam()), mesh_of(cube_in_a_corner(GetParam())));
  Momenta before = session.balance().momenta();
  const bool is_euler = GetParam() == Integrator::kBackwardEuler;
  // Backward Euler stops where the residual, and with it the change of momentum that no force explains, is small.
  const double bound = is_euler ? 1e-7 : 1e-10;
  Vector3 largest = Vector3::Zero();
  while (session.step()) {
    const Momenta& after = session.balance().momenta();
    const double h = session.steps().last;
    const std::vector<Vector3> probes = values_of_probes(session);
    ASSERT_EQ(probes.size(), 5U);
    const Vector3 force = (after.linear - before.linear) / h;
    const Vector3 moment = (after.angular - before.angular) / h;
    EXPECT_LT((probes[0] + probes[1] - force).norm(), bound * after.linear_scale / h);
    if (!is_euler) {  // it changes the angular momentum of a spin on its own
      EXPECT_LT((probes[2] + probes[3] - moment).norm(), 1e-8 * after.angular_scale / h);
    }
    EXPECT_LT((probes[4] - (probes[3] - kNowhere.cross(probes[1]))).norm(),
              1e-14 * (1.0 + probes[3].norm() + probes[1].norm()));
    for (Index k = 0; k < 2; ++k) {
      largest[k] = std::max(largest[k], probes[static_cast<std::size_t>(k)].norm());
    }
    before = after;
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  for (std::size_t k = 0; k < 2; ++k) {
    const double expected = session.balance().sums().obstacles[k].largest_force;
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(largest[static_cast<Index>(k)], expected, 1e-12 * expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, ObstacleProbe, testing::ValuesIn(all_rules()), name_of_rule);

// A step that is made in several has the mean over all of it.
TEST(ObstacleProbes, AreMeansOverTheWholeStep) {
  Scene scene = cube_in_a_corner(Integrator::kEnergyMomentum);
  scene.time.adapt = StepAdaptation::kError;
  scene.time.tolerance = 1e-4;
  Session session(scene, mesh_of(scene));
  Vector3 before = session.balance().momenta().linear;
  while (session.step()) {
    const Momenta& after = session.balance().momenta();
    const std::vector<Vector3> probes = values_of_probes(session);
    const Vector3 force = (after.linear - before) / session.steps().last;
    EXPECT_EQ(session.step_control().last_substeps, 2);
    EXPECT_LT((probes[0] + probes[1] - force).norm(),
              1e-10 * after.linear_scale / session.steps().last);
    before = after.linear;
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
}

// An equilibrium, and a body that begins in a layer, have the force at the instant.
TEST(ObstacleProbes, AreForcesAtTheStateWhereThereIsNoStep) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.3, 0.2}, {3, 3, 3}}, elastic(1e5, 0.3));
  scene.environment = gravity(9.81);
  scene.fix.push_back(fix(SelectVertices{{0}}, {true, false, true}));
  scene.fix.push_back(fix(SelectNearest{{0.2, 0.0, 0.0}}, {false, false, true}));
  scene.obstacle = {plane_obstacle("floor", {0.0, -0.001, 0.0})};
  scene.probe = {probe_on("floor", "floor")};
  const double weight = 9.81 * 1000.0 * 0.2 * 0.3 * 0.2;
  const FinishedEquilibrium equilibrium(scene);
  const Vector3 carried = values_of_probes(equilibrium)[0];
  EXPECT_NEAR(carried.y(), weight, 1e-8 * weight);

  scene.time = {Integrator::kVerlet, 1e-5, false, 1e-4};
  Session session(scene, mesh_of(scene));
  const ForcePoint at = session.system().force_point(session.state().position, 0.0);
  const Vector3 expected = session.system().contact()->forces(at)[0].force;
  EXPECT_GT(expected.y(), 0.0);
  EXPECT_EQ(values_of_probes(session)[0], expected);
}

// A step that fails leaves the values as they were.
TEST(ObstacleProbes, KeepTheirValuesWhereAStepFails) {
  Scene scene = cube_in_a_corner(Integrator::kVerlet);
  scene.time.end = 0.03;
  Session session(scene, mesh_of(scene));
  while (session.step() && values_of_probes(session)[0].norm() == 0.0) {
  }
  const std::vector<Vector3> before = values_of_probes(session);
  ASSERT_GT(before[0].norm(), 0.0);
  // A blow makes the next step penetrate the floor.
  session.apply(SetMomentum{{SelectAll{}, {0.0, -1e3, 0.0}, {}}});
  EXPECT_FALSE(session.step());
  EXPECT_NE(session.status(), RunStatus::kRunning);
  EXPECT_EQ(values_of_probes(session), before);
}

TEST(ObstacleProbes, AreThoseOfACheckpoint) {
  const Scene scene = cube_in_a_corner(Integrator::kEnergyMomentum);
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 25; ++k) ASSERT_TRUE(session.step());
  Session other(scene, mesh_of(scene));
  other.restore(session.checkpoint());
  EXPECT_GT(values_of_probes(session)[0].norm(), 0.0);
  EXPECT_EQ(values_of_probes(session), values_of_probes(other));
  ASSERT_TRUE(session.step());
  ASSERT_TRUE(other.step());
  EXPECT_EQ(values_of_probes(session), values_of_probes(other));
}

TEST(ObstacleProbes, RefuseWhatIsNotThere) {
  const auto refusal = [](const ProbeSettings& probe, bool has_obstacles = true) {
    Scene scene = cube_in_a_corner(Integrator::kVerlet);
    if (!has_obstacles) scene.obstacle.clear();
    scene.probe = {probe};
    scene.probe[0].where = "here.toml:3:1: probe.0";
    return message_of([&] { const Session session(scene, mesh_of(scene)); });
  };
  EXPECT_EQ(
      refusal(probe_on("lift", "flor")),
      "here.toml:3:1: probe.0: the probe \"lift\" is of the obstacle \"flor\", but did you mean "
      "\"floor\"? the scene has floor or wall.");
  EXPECT_EQ(
      refusal(probe_on("lift", "ceiling")),
      "here.toml:3:1: probe.0: the probe \"lift\" is of the obstacle \"ceiling\", but the scene "
      "has floor or wall.");
  EXPECT_NE(refusal(probe_on("lift", "floor"), false).find("the scene has no [[obstacle]]"),
            std::string::npos);
  const auto expect = [&](const ProbeSettings& probe, const std::string& part) {
    EXPECT_NE(refusal(probe).find(part), std::string::npos) << refusal(probe);
  };
  expect(probe_of("lift", ProbeQuantity::kContactForce), "give its name, obstacle = \"NAME\"");
  expect(probe_on("lift", "floor", ProbeQuantity::kVelocity), "is none of an obstacle");
  expect(probe_on("lift", "floor", ProbeQuantity::kContactForce, {1.0, 0.0, 0.0}),
         "is for quantity = \"contact_moment\" only");
}

}  // namespace
}  // namespace tetraction
