// Drag, mass damping and internal viscosity with every rule.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

class DampedBy : public testing::TestWithParam<Integrator> {
 protected:
  bool implicit() const { return is_implicit(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Rules, DampedBy, testing::ValuesIn(all_rules()), name_of_rule);

TEST_P(DampedBy, ZeroConstantsGiveBitwiseTheUndampedRun) {
  const Scene scene = spinning_block(GetParam(), 1e-3, 0.05);
  Scene zero = scene;
  zero.damping = {0.0, 0.0, 0.0};
  Session a(scene, mesh_of(scene));
  Session b(zero, mesh_of(scene));
  ASSERT_EQ(a.run(), RunStatus::kFinished);
  ASSERT_EQ(b.run(), RunStatus::kFinished);
  EXPECT_EQ(a.state().position, b.state().position);
  EXPECT_EQ(a.state().momentum, b.state().momentum);
  EXPECT_EQ(b.balance().dissipated_energy(), 0.0);
}

TEST_P(DampedBy, ViscosityKeepsMomentumWhileEnergyFalls) {
  Scene scene = spinning_block(GetParam(), 1e-3, 1.0);
  scene.damping.viscosity = 100.0;
  Session session(scene, mesh_of(scene));
  // Means over windows of 50 steps fall: what one step does is the integrator's oscillation.
  std::vector<double> means;
  double sum = 0.0;
  while (session.step()) {
    sum += session.balance().energies().total();
    if (session.state().step % 50 == 0) {
      means.push_back(sum / 50.0);
      sum = 0.0;
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  for (std::size_t i = 1; i < means.size(); ++i) {
    EXPECT_LT(means[i], means[i - 1] * (1.0 + 1e-9)) << i;
  }
  EXPECT_GT(session.balance().dissipated_energy(), 1.0);
  if (GetParam() == Integrator::kBackwardEuler) return;  // loses angular momentum of itself
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12);
  if (implicit()) {
    EXPECT_LT(session.balance().angular_momentum_drift(),
              session.balance().allowed_angular_momentum_drift() + 1e-12);
  } else {
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-12);
  }
}

TEST_P(DampedBy, MassDampingMakesMomentumDecayExponentially) {
  constexpr double kRate = 3.0;
  Scene scene = spinning_block(GetParam(), 1e-3, 0.5);
  scene.damping.mass_damping = kRate;
  Session session(scene, mesh_of(scene));
  const Vector3 start = session.balance().momenta().linear;
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const Vector3 exact = std::exp(-kRate * 0.5) * start;
  const double ah = kRate * session.time_step();
  const double tolerance = order(GetParam()) == 2 ? ah * ah : ah;
  EXPECT_LT((session.balance().momenta().linear - exact).norm(), tolerance * exact.norm());
}

TEST_P(DampedBy, DragTakesTheMomentumOfEachVertex) {
  // A body of equal vertex masses in pure translation: drag is mass damping of k_D/m.
  Scene scene = scene_of({GeneratorKind::kTetrahedron, {1, 1, 1}, {1, 1, 1}}, elastic(1e5, 0.3));
  scene.initial.velocity = {1.0, 2.0, -1.0};
  scene.time = {GetParam(), 1e-3, false, 0.2};
  scene.damping.drag = 100.0;
  Session session(scene, generate_tetrahedron());
  const double rate = 100.0 / session.system().mass()[0];
  const Vector3 start = session.balance().momenta().linear;
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const double ah = rate * session.time_step();
  EXPECT_LT((session.balance().momenta().linear - std::exp(-rate * 0.2) * start).norm(),
            (order(GetParam()) == 2 ? ah * ah : ah) * start.norm());
  // The energy that left the body is in the balance.
  EXPECT_NEAR(session.balance().dissipated_energy(),
              0.5 * session.system().total_mass() * 6.0 * (1.0 - std::exp(-2.0 * rate * 0.2)),
              2.0 * ah * 0.5 * session.system().total_mass() * 6.0);
}

// The dissipated energy over a fixed time converges with the order of the rule.
TEST_P(DampedBy, DissipatedEnergyConvergesWithTheRulesOrder) {
  const auto dissipated = [&](double step) {
    Scene scene = spinning_block(GetParam(), step, 0.128);
    scene.damping = {0.5, 0.4, 60.0};
    scene.solver.tolerance = 1e-11;
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return session.balance().dissipated_energy();
  };
  const double h = 1e-3;
  const double coarse = dissipated(h);
  const double middle = dissipated(h / 2);
  const double fine = dissipated(h / 4);
  const double observed = std::log2(std::abs((coarse - middle) / (middle - fine)));
  EXPECT_NEAR(observed, order(GetParam()), 0.2);
}

TEST_P(DampedBy, OneModeDecaysAtTheAnalyticRate) {
  // A bar that moves along x only, fixed at x = 0, in its first mode: ω = πc/(2L). Kelvin–Voigt
  // stress 2ηĖ beside (λ + 2μ)E: ζ = ηω/(λ + 2μ), amplitude exp(−ζωt).
  constexpr double kAmplitude = 1e-6;
  constexpr double kEta = 400.0;
  const LameParameters lame = lame_from_young(1e6, 0.3);
  const double modulus = lame.lambda + 2.0 * lame.mu;
  const double omega = 0.5 * std::numbers::pi * std::sqrt(modulus / 1000.0);
  const double decay = kEta * omega * omega / modulus;
  Scene scene = scene_of({GeneratorKind::kBox, {1, 0.1, 0.1}, {20, 1, 1}}, elastic(1e6, 0.3));
  const int steps_per_period = implicit() ? 800 : 2000;
  const double period = 2.0 * std::numbers::pi / omega;
  scene.time = {GetParam(), period / steps_per_period, false, 3.0 * period};
  scene.damping.viscosity = kEta;
  scene.solver.tolerance = 1e-9;
  scene.fix = {fix(SelectPlane{0, 0.0, {}}), fix(SelectAll{}, {false, true, true})};
  TetMesh mesh = mesh_of(scene);
  Matrix shape = Matrix::Zero(3, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    shape(0, v) = kAmplitude *
                  std::sin(0.5 * std::numbers::pi * mesh.vertices[static_cast<std::size_t>(v)].x());
  }
  mesh.point_arrays["mode"] = shape;
  scene.initial.displacement_array = "mode";
  Session session(scene, mesh);
  const Index end_dof = 3 * (mesh.vertex_count() - 1);
  std::vector<double> peaks;  // of the energy, which does not depend on the phase
  const double energy = session.balance().energies().total();
  (void)end_dof;
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const double measured =
      -0.5 * std::log(session.balance().energies().total() / energy) / scene.time.end;
  // Backward Euler adds its own damping hω²/2.
  const double own =
      GetParam() == Integrator::kBackwardEuler ? 0.5 * session.time_step() * omega * omega : 0.0;
  EXPECT_NEAR(measured, decay + own, 0.01 * (decay + own));
}

TEST(DampedStability, TheLimitAccountsForTheDamping) {
  // Above the stated limit the run blows up, below it does not, for damping alone and mixed.
  for (const Damping& damping :
       {Damping{0.0, 0.0, 3000.0}, Damping{0.0, 900.0, 0.0}, Damping{300.0, 0.0, 800.0}}) {
    Scene scene = spinning_block(Integrator::kExplicit, 1e-6, 1e-4);
    scene.initial.stretch = {1.001, 1.0, 0.999};
    scene.initial.angular_velocity = {0.0, 0.0, 0.0};
    scene.damping = damping;
    const TetMesh mesh = mesh_of(scene);
    const StabilityLimit limit = Session(scene, mesh).initial_limit();
    EXPECT_LT(limit.critical_step, 2.0 / limit.omega_max);
    scene.time.step = 0.95 * limit.critical_step;
    scene.time.end = 2000 * scene.time.step;
    Session below(scene, mesh);
    EXPECT_EQ(below.run(), RunStatus::kFinished) << below.message();
    scene.time.step = 1.5 * limit.critical_step;
    scene.time.end = 4000 * scene.time.step;
    Session above(scene, mesh);
    EXPECT_EQ(above.run(), RunStatus::kUnstable);
  }
}

}  // namespace
}  // namespace tetraction
