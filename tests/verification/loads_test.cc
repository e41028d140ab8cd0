// Loads that change in time, distributed loads and pressure, with every rule and solver: momentum is
// the exact integral of the load, and the balance of energy closes.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "support/corner_scenes.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {
namespace {

using namespace testing_support;

AmplitudeSettings hat() {
  return corners("hat", {{0.0111, 0.0}, {0.0234, 2.5}, {0.0357, -0.4}});
}
constexpr double kHatIntegral = 0.5 * 2.5 * 0.0123 + 0.5 * 2.1 * 0.0123 - 0.4 * (0.06 - 0.0357);

class Loads : public testing::TestWithParam<RuleWithSolver> {
 protected:
  Scene block(double step, double end) const {
    Scene scene = scene_of({GeneratorKind::kBox, {0.4, 0.2, 0.2}, {4, 2, 2}}, elastic(5e4, 0.3));
    scene.time = {GetParam().integrator, step, false, end};
    scene.solver = GetParam().solver;
    scene.solver.tolerance = 1e-10;
    return scene;
  }
  static Session session_of(const Scene& scene) {
    return Session(scene, generate_mesh(*scene.mesh.generate));
  }
  bool has_second_order() const { return order(GetParam().integrator) == 2; }
  // The momenta of backward Euler carry the residual that the solver leaves in every step.
  double exactness() const {
    return GetParam().integrator == Integrator::kBackwardEuler ? 1e-8 : 1e-12;
  }
};

INSTANTIATE_TEST_SUITE_P(All, Loads, testing::ValuesIn(rules_with_solvers()), name_with_solver);

// Corners of the amplitude and the window of the force lie inside steps, and within one step.
TEST_P(Loads, TheMomentumIsTheIntegralOfTheLoad) {
  for (const double step : {3e-4, 1e-3}) {
    Scene scene = block(step, 0.06);
    scene.amplitude = {hat()};
    ForceSettings force = total_load(SelectPlane{0, 0.4, {}}, {3.0, -1.0, 0.5});
    force.amplitude = "hat";
    scene.force = {force};
    ForceSettings traction = testing_support::traction(SelectPlane{1, 0.2, {}}, {0.0, 50.0, 20.0});
    traction.from = 0.01234;
    traction.until = 0.01241;  // shorter than a step
    scene.traction = {traction};
    ForceSettings body = body_acceleration({0.0, 0.0, 2.0});
    body.amplitude = "hat";
    scene.body_force = {body};
    FinishedRun session(scene);
    const double mass = session.system().total_mass();
    EXPECT_NEAR(mass, 16.0, 1e-12);
    const Vector3 expected = kHatIntegral * (*force.total + mass * *body.acceleration) +
                             (0.01241 - 0.01234) * 0.4 * 0.2 * traction.vector;
    EXPECT_LT((session.balance().momenta().linear - expected).norm(),
              exactness() * expected.norm());
    EXPECT_LT(session.balance().linear_momentum_drift(), exactness());
    EXPECT_LT(session.balance().max_relative_energy_drift(), has_second_order() ? 2e-3 : 0.2);
  }
}

TEST_P(Loads, AnEnvironmentWithAnAmplitudeGivesItsIntegral) {
  for (const double step : {3e-4, 1e-3}) {
    Scene scene = block(step, 0.06);
    scene.amplitude = {hat()};
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.environment.amplitude = "hat";
    FinishedRun session(scene);
    const Vector3 expected =
        session.system().total_mass() * kHatIntegral * Vector3(0.0, -9.81, 0.0);
    EXPECT_LT((session.balance().momenta().linear - expected).norm(),
              exactness() * expected.norm());
    // The body moves as a whole, and each rule has its own error of the kinetic energy: none for
    // those of second order, since the work is the mean force times the displacement.
    EXPECT_LT(session.balance().max_relative_energy_drift(), has_second_order() ? 1e-9 : 0.2);
  }
}

// A moment turns the body: its impulse is the angular momentum, as long as the body has hardly moved.
TEST_P(Loads, AMomentGivesAngularMomentum) {
  Scene scene = block(1e-4, 2e-3);
  scene.moment = {moment(SelectPlane{0, 0.4, {}}, {0.02, 0.0, 0.0})};
  FinishedRun session(scene);
  EXPECT_LT(session.balance().momenta().linear.norm(),
            1e-9 * session.balance().momenta().linear_scale);
  EXPECT_NEAR(session.balance().momenta().angular.x(), 0.02 * 2e-3, 1e-3 * 0.02 * 2e-3);
}

TEST_P(Loads, AFixFollowsItsAmplitudeAndAHandleTurnsByItsIntegral) {
  Scene scene = block(1e-3, 0.05);
  scene.amplitude = {hat(), sine("swing", 20.0)};
  FixSettings fix = shifted(SelectPlane{0, 0.0, {}}, {0.0, 0.004, 0.0});
  fix.amplitude = "swing";
  scene.fix = {fix};
  ConstraintSettings handle = driven(SelectPlane{0, 0.4, {}}, {}, Vector3(20.0, 0.0, 0.0));
  handle.amplitude = "hat";
  scene.constraint = {handle};
  Session session = session_of(scene);
  const TetMesh& mesh = session.system().mesh();
  const std::vector<Index> held = select_vertices(mesh, fix.select);
  const std::vector<Index> turned = select_vertices(mesh, handle.select);
  const Amplitude angle = make_amplitude(hat());
  Vector3 low = mesh.vertices[static_cast<std::size_t>(turned.front())];
  Vector3 high = low;
  for (const Index v : turned) {
    low = low.cwiseMin(mesh.vertices[static_cast<std::size_t>(v)]);
    high = high.cwiseMax(mesh.vertices[static_cast<std::size_t>(v)]);
  }
  const Vector3 center = 0.5 * (low + high);  // of the end's rectangle
  while (session.step()) {
    const double time = session.time();
    const double shift = 0.004 * std::sin(2.0 * std::numbers::pi * 20.0 * time);
    for (const Index v : held) {
      const Vector3 expected =
          mesh.vertices[static_cast<std::size_t>(v)] + Vector3(0.0, shift, 0.0);
      EXPECT_LT((vertex_block(session.state().position, v) - expected).norm(), 1e-16);
    }
    const double turn = 20.0 * angle.integral({0.0, time});
    for (const Index v : turned) {
      const Vector3 arm = mesh.vertices[static_cast<std::size_t>(v)] - center;
      const Vector3 turned_arm(arm.x(), std::cos(turn) * arm.y() - std::sin(turn) * arm.z(),
                               std::sin(turn) * arm.y() + std::cos(turn) * arm.z());
      const Vector3 expected = center + turned_arm;
      EXPECT_LT((vertex_block(session.state().position, v) - expected).norm(), 1e-14);
    }
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_LT(session.balance().max_relative_energy_drift(), has_second_order() ? 5e-3 : 0.3);
}

// Water pressure all around a free body neither moves nor turns it, and its work closes the balance.
TEST_P(Loads, PressureAllAroundKeepsMomentaAndTheBalance) {
  const auto error = [&](double step) {
    Scene scene = block(step, 0.03);
    scene.pressure = {pressure(SelectSurface{}, 5e3)};  // a tenth of Young's modulus
    scene.initial.angular_velocity = {0.0, 0.0, 20.0};
    Session session = session_of(scene);
    const Vector3 start = session.balance().momenta().angular;
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const Momenta& momenta = session.balance().momenta();
    EXPECT_LT(momenta.linear.norm(), 1e-10 * momenta.linear_scale);
    if (is_variational(GetParam().integrator)) {
      EXPECT_LT((momenta.angular - start).norm(), 1e-8 * start.norm());
    }
    EXPECT_GT(session.balance().external_work(), 0.01 * session.balance().energy_scale());
    return session.balance().max_relative_energy_drift();
  };
  const double coarse = error(4e-4);
  const double fine = error(1e-4);
  if (GetParam().integrator == Integrator::kEnergyMomentum) {
    EXPECT_LT(std::max(coarse, fine), 1e-10);
    return;
  }
  EXPECT_LT(fine, has_second_order() ? 1e-3 : 0.1);
  EXPECT_LT(fine, coarse / (has_second_order() ? 8.0 : 2.5));
}

// A pressure on a face whose rim moves has no potential. The forces on the rim are those of positions
// predicted for the middle of the step, so that the rules keep their order.
TEST_P(Loads, PressureOnAFaceWithAFreeRimKeepsTheOrder) {
  const auto end = [&](double step) {
    Scene scene = block(step, 0.02);
    scene.fix = {fix(SelectPlane{0, 0.0, {}})};
    scene.pressure = {pressure(SelectPlane{1, 0.2, {}}, 2e3)};
    Session session = session_of(scene);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return Vector(session.state().position);
  };
  const Vector coarse = end(4e-4);
  const Vector middle = end(2e-4);
  const Vector fine = end(1e-4);
  const double ratio = (coarse - middle).norm() / (middle - fine).norm();
  EXPECT_GT(ratio, has_second_order() ? 3.5 : 1.7);
  EXPECT_LT(ratio, has_second_order() ? 4.5 : 2.4);
}

// The forces on a free rim depend so strongly on the positions that taking them at the last result
// again and again would diverge, in large steps and in the equilibrium.
TEST(LoadsWithoutPotential, SettleInLargeStepsAndInTheEquilibrium) {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {8, 2, 1}}, elastic(1e6, 0.3));
  scene.time = {Integrator::kBackwardEuler, 0.5, false, 40.0};
  FixSettings sides = fix(SelectPlane{2, 0.0, {}}, {false, false, true});
  scene.fix = {fix(SelectPlane{0, 0.0, {}}), sides};
  sides.select = SelectPlane{2, 1.0, {}};
  scene.fix.push_back(sides);
  ForceSettings pressure = testing_support::pressure(SelectFaces{{0.0, 1.0, 0.0}, 10.0}, 2e4);
  scene.pressure = {pressure};
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  FinishedRun session(scene, mesh);
  EXPECT_LT(session.balance().energies().kinetic(), 1e-6 * session.balance().energies().elastic());
  const Equilibrium equilibrium = find_equilibrium(session.system());
  ASSERT_TRUE(equilibrium.found) << equilibrium.message;
  const double moved = (equilibrium.position - mesh.rest_positions()).norm();
  EXPECT_GT(moved, 5.0) << "the deformation is large";
  EXPECT_LT((session.state().position - equilibrium.position).norm(), 1e-5 * moved);
  // The forces are those of the pressure on the deformed face, the corners of the rim included.
  Vector3 area = Vector3::Zero();
  for (const auto& [a, b, c] : session.system().pressures()[0].triangles) {
    const Vector3 x = vertex_block(equilibrium.position, a);
    area += 0.5 * (Vector3(vertex_block(equilibrium.position, b)) - x)
                      .cross(Vector3(vertex_block(equilibrium.position, c)) - x);
  }
  const Vector3 applied = equilibrium.load.reshaped(3, mesh.vertex_count()).rowwise().sum();
  EXPECT_LT((applied + 2e4 * area).norm(), 1e-9 * applied.norm());
}

}  // namespace
}  // namespace tetraction
