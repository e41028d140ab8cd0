// User forces and environments: momenta change by exactly their impulses.
#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

#include "support/runs.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {
namespace {

using namespace testing_support;

class EveryRule : public testing::TestWithParam<Integrator> {
 protected:
  bool implicit() const { return is_implicit(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Rules, EveryRule, testing::ValuesIn(all_rules()), name_of_rule);

// A free block with forces on two single vertices, one of them for a while.
Scene pushed_block(Integrator integrator) {
  Scene scene = spinning_block(integrator, 2e-3, 0.2);
  scene.solver.tolerance = 1e-10;
  ForceSettings pull = load(SelectVertices{{7, 11}}, {0.0, 250.0, -50.0});
  pull.from = 0.05;
  pull.until = 0.1;
  scene.force = {load(SelectVertices{{0}}, {300.0, -200.0, 100.0}), pull};
  return scene;
}

TEST_P(EveryRule, TotalMomentumChangesByTheImpulseInEveryStep) {
  const Scene scene = pushed_block(GetParam());
  Session session(scene, mesh_of(scene));
  const double h = session.time_step();
  Vector3 before = session.balance().momenta().linear;
  for (int k = 0; k < 100; ++k) {
    const double t = session.state().time;
    ASSERT_TRUE(session.step()) << session.message();
    Vector3 impulse = h * scene.force[0].vector;
    if (t > 0.05 - 1e-9 && t < 0.1 - 1e-9) impulse += 2.0 * h * scene.force[1].vector;
    const Vector3 after = session.balance().momenta().linear;
    const double scale = session.balance().momenta().linear_scale;
    // Backward Euler takes p = Mv, so that the solver's residual shows.
    const double tolerance = GetParam() == Integrator::kBackwardEuler ? 1e-9 : 1e-13;
    EXPECT_LT((after - before - impulse).norm(), tolerance * scale) << "step " << k;
    before = after;
  }
}

TEST_P(EveryRule, CentreOfMassFollowsTheDiscreteTrajectoryHoweverTheBodyDeforms) {
  const Scene scene = pushed_block(GetParam());
  Session session(scene, mesh_of(scene));
  const MechanicalSystem& system = session.system();
  const double h = session.time_step();
  const double m = system.total_mass();
  Vector3 x = center_of_mass(system, session.state().position);
  Vector3 p = session.balance().momenta().linear;
  for (int k = 0; k < 100; ++k) {
    const double t = session.state().time;
    ASSERT_TRUE(session.step()) << session.message();
    Vector3 f = scene.force[0].vector;
    if (t > 0.05 - 1e-9 && t < 0.1 - 1e-9) f += 2.0 * scene.force[1].vector;
    // The rule applied to one mass: α of the force's impulse is in the step's velocity.
    const bool second_order = order(GetParam()) == 2;
    x += h / m * (p + (second_order ? 0.5 : 1.0) * h * f);
    p += h * f;
  }
  const double moved = (x - Vector3(1.0, 0.5, 0.5)).norm();
  EXPECT_LT((center_of_mass(system, session.state().position) - x).norm(),
            (implicit() ? 1e-9 : 1e-13) * moved);
}

TEST_P(EveryRule, ACoupleSpinsTheBodyUpByItsAngularImpulse) {
  // Nothing but a couple: forces along y on both ends of an edge along x, which turns meanwhile.
  Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {2, 1, 1}}, elastic(1e5, 0.3));
  scene.time = {GetParam(), 2e-3, false, 0.4};
  scene.solver.tolerance = 1e-11;
  ForceSettings up = load(SelectNearest{{2, 0, 0}}, {0, 80, 0});
  ForceSettings down = load(SelectNearest{{0, 0, 0}}, {0, -80, 0});
  scene.force = {up, down};
  const TetMesh mesh = mesh_of(scene);
  const Index right = select_vertices(mesh, up.select).front();
  const Index left = select_vertices(mesh, down.select).front();
  Session session(scene, mesh);
  const double h = session.time_step();
  for (int k = 0; k < 200; ++k) {
    const Vector before = session.state().position;
    const Vector3 l = session.balance().momenta().angular;
    ASSERT_TRUE(session.step()) << session.message();
    // Where the rule takes the force: at q_k, at both ends, at the middle, at the end.
    const auto arm = [&](const Vector& q) {
      return Vector3(q.segment<3>(3 * right) - q.segment<3>(3 * left));
    };
    const Vector3 begin = arm(before);
    const Vector3 end = arm(session.state().position);
    const Vector3 mean = 0.5 * (begin + end);
    const Vector3 lever = GetParam() == Integrator::kExplicit        ? begin
                          : GetParam() == Integrator::kBackwardEuler ? end
                                                                     : mean;
    const Vector3 change = session.balance().momenta().angular - l;
    const Vector3 impulse = h * lever.cross(up.vector);
    if (GetParam() == Integrator::kBackwardEuler) {
      // Not variational: it loses some of what it has.
      EXPECT_LT((change - impulse).norm(), 0.05 * impulse.norm());
    } else {
      EXPECT_LT((change - impulse).norm(), (implicit() ? 1e-7 : 1e-12) * impulse.norm())
          << "step " << k;
    }
  }
  EXPECT_GT(session.balance().momenta().angular.z(), 50.0);
}

TEST_P(EveryRule, AForceOnAFixedVertexShowsInItsReactionOnly) {
  Scene scene = spinning_block(GetParam(), 2e-3, 0.1);
  scene.initial = {};
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  Scene loaded = scene;
  ForceSettings force = load(SelectVertices{{0}}, {12.0, -34.0, 56.0});
  loaded.force = {force};
  const TetMesh mesh = mesh_of(scene);
  Session without(scene, mesh);
  Session with(loaded, mesh);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(without.step());
    ASSERT_TRUE(with.step());
    // The tolerance of an implicit step is relative to its loads, reactions included or not.
    EXPECT_LT((with.state().position - without.state().position).norm(),
              implicit() ? 1e-10 : 0.0 + 1e-300);
    const Vector difference = with.reaction_force() - without.reaction_force();
    EXPECT_LT((difference.segment<3>(0) + force.vector).norm(),
              (implicit() ? 1e-5 : 1e-9) * force.vector.norm());
    EXPECT_LT(difference.tail(difference.size() - 3).norm(), implicit() ? 1e-3 : 1e-9);
    EXPECT_EQ(with.balance().external_work(), 0.0);
  }
}

// A small stiff body on a circle around the centre.
Scene orbiting_body(Integrator integrator) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.1, 0.1, 0.1}, {1, 1, 1}}, elastic(1e5, 0.3));
  scene.time = {integrator, 0.0, true, 1.0};
  scene.environment = {EnvironmentKind::kAttraction, 1.0, Vector3::UnitY(), 0.0};
  return scene;
}

TEST(Attraction, AStiffBodyKeepsEnergyAndAngularMomentumOver100Revolutions) {
  Scene scene = orbiting_body(Integrator::kVerlet);
  TetMesh mesh = mesh_of(scene);
  constexpr double kRadius = 1.0;
  for (Vector3& x : mesh.vertices.own()) x += Vector3(kRadius - 0.05, -0.05, -0.05);
  const double mass = 1000.0 * 1e-3;
  const double n = static_cast<double>(mesh.vertex_count());
  const double omega = std::sqrt(n * scene.environment.strength / mass) / std::pow(kRadius, 1.5);
  scene.initial.velocity = {0.0, omega * kRadius, 0.0};
  scene.initial.angular_velocity = {0.0, 0.0, omega};
  scene.time.end = 100.0 * 2.0 * std::numbers::pi / omega;
  FinishedRun session(scene, mesh);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-4);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-11);
  // It is still there, on its circle.
  const Vector3 center = center_of_mass(session.system(), session.state().position);
  EXPECT_NEAR(center.norm(), kRadius, 0.02 * kRadius);
}

TEST(Attraction, ImplicitStepsConvergeWithTheIndefiniteHessian) {
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    Scene scene = orbiting_body(integrator);
    TetMesh mesh = mesh_of(scene);
    for (Vector3& x : mesh.vertices.own()) x += Vector3(0.95, -0.05, -0.05);
    const double omega = std::sqrt(8.0 / 1.0);
    scene.initial.velocity = {0.0, omega, 0.0};
    // Backward Euler spirals inward: h²ω² of the orbit's energy are lost in every step.
    const bool midpoint = integrator == Integrator::kMidpoint;
    scene.time = {integrator, midpoint ? 0.02 : 0.002, false, 4.0};
    FinishedRun session(scene, mesh);
    EXPECT_LT(session.total_iterations(), 6 * session.state().step) << to_string(integrator);
    if (!midpoint) continue;
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-3);
    EXPECT_LT(session.balance().angular_momentum_drift(),
              session.balance().allowed_angular_momentum_drift() + 1e-12);
  }
}

TEST(Attraction, LargeStepsThroughASoftenedCentreConvergeWhereTheInertiaDoesNotDominate) {
  // 2k/ε³ = 2000 N/m against m/s² = 8 to 50 N/m of a vertex: the Hessian of Φ is indefinite on the
  // way through the centre.
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    Scene scene = orbiting_body(integrator);
    scene.environment.softening = 0.1;
    TetMesh mesh = mesh_of(scene);
    for (Vector3& x : mesh.vertices.own()) x += Vector3(0.45, 0.02, -0.03);
    // The energy error of midpoint at larger steps is another matter.
    scene.time = {integrator, integrator == Integrator::kMidpoint ? 0.04 : 0.1, false, 4.0};
    FinishedRun session(scene, mesh);
    EXPECT_LT(session.total_iterations(), 25 * session.state().step) << to_string(integrator);
  }
}

TEST(Attraction, AVertexAtTheOriginIsHandledWithoutNan) {
  // Vertex 0 is exactly at the origin, where it feels nothing, until elasticity moves it off: then
  // the force is beyond any bound, which has to end the run with the reason.
  Scene scene = orbiting_body(Integrator::kVerlet);
  scene.time = {Integrator::kVerlet, 1e-5, false, 1e-3};
  scene.environment.strength = 1e-3;
  Session session(scene, mesh_of(scene));
  EXPECT_TRUE(std::isfinite(session.balance().energies().environment()));
  EXPECT_EQ(session.run(), RunStatus::kUnstable);
  EXPECT_NE(session.message().find("softening"), std::string::npos) << session.message();
  EXPECT_TRUE(session.state().position.allFinite());
}

TEST(Attraction, FallingIntoTheCentreIsAnOutcomeWithAnExplanation) {
  Scene scene = orbiting_body(Integrator::kVerlet);
  TetMesh mesh = mesh_of(scene);
  for (Vector3& x : mesh.vertices.own()) x += Vector3(0.5, 0.0, 0.0);  // vertex 0 falls straight in
  scene.environment.strength = 5.0;
  scene.time = {Integrator::kVerlet, 1e-4, false, 2.0};
  Session session(scene, mesh);
  EXPECT_EQ(session.run(), RunStatus::kUnstable);
  EXPECT_NE(session.message().find("softening"), std::string::npos) << session.message();
  EXPECT_TRUE(session.state().position.allFinite());

  scene.environment.softening = 0.1;
  scene.time.step = 1e-4;
  Session softened(scene, mesh);
  EXPECT_EQ(softened.run(), RunStatus::kFinished) << softened.message();
}

}  // namespace
}  // namespace tetraction
