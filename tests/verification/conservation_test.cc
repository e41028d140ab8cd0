// The conservation laws of each rule, on a free, spinning, stretched block over many steps.
#include <cmath>
#include <numeric>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

TetMesh block_of(const Scene& scene) {
  return generate_mesh(*scene.mesh.generate);
}

double stable_step() {
  const Scene scene = spinning_block(Integrator::kVerlet, 1e-6, 1e-6);
  return Session(scene, block_of(scene)).initial_limit().critical_step;
}

class ExplicitConservation : public testing::TestWithParam<Integrator> {};

TEST_P(ExplicitConservation, MomentaStayToRoundOffOver10000Steps) {
  const double step = 0.3 * stable_step();
  const Scene scene = spinning_block(GetParam(), step, 10000 * step);
  FinishedRun session(scene, block_of(scene));
  ASSERT_EQ(session.state().step, 10000);
  EXPECT_GT(session.balance().momenta().angular_scale, 1.0);
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-12);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Rules, ExplicitConservation,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet),
                         [](const auto& test) { return to_string(test.param); });

TEST(MidpointConservation, LinearMomentumToRoundOffAngularToTolerance) {
  const double step = 0.5 * stable_step();
  const Scene scene = spinning_block(Integrator::kMidpoint, step, 10000 * step);
  FinishedRun session(scene, block_of(scene));
  ASSERT_EQ(session.state().step, 10000);
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-8);
  // The drift that the residuals allow is stated, and it bounds the measured one (but for round-off).
  EXPECT_GT(session.balance().allowed_angular_momentum_drift(), 0.0);
  EXPECT_LE(session.balance().angular_momentum_drift(),
            session.balance().allowed_angular_momentum_drift() + 1e-12);
}

// Loads and reactions cancel up to their round-off, which is no drift beside their own size.
TEST(MomentumDrift, OfABodyThatIsHeldIsRoundOff) {
  for (const Integrator rule : all_integrators()) {
    const double step = 0.5 * stable_step();
    Scene scene = spinning_block(rule, step, 30 * step);
    scene.initial = {};
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.fix.emplace_back();
    ForceSettings load;
    load.total = Vector3(200.0, 100.0, -300.0);
    scene.force.push_back(load);
    FinishedRun session(scene, block_of(scene));
    EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12) << to_string(rule);
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-12) << to_string(rule);
  }
}

TEST(VerletEnergy, DoesNotDriftOver100000Steps) {
  const double step = 0.1 * stable_step();
  const Scene scene = spinning_block(Integrator::kVerlet, step, 100000 * step);
  Session session(scene, block_of(scene));
  std::vector<double> energy;
  while (session.step()) energy.push_back(session.balance().energies().total());
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const auto mean = [&](std::size_t begin) {
    return std::accumulate(energy.begin() + static_cast<std::ptrdiff_t>(begin),
                           energy.begin() + static_cast<std::ptrdiff_t>(begin + 10000), 0.0) /
           10000.0;
  };
  EXPECT_NEAR(mean(90000) / mean(0), 1.0, 1e-3);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.01);
}

TEST(BackwardEulerEnergy, FallsAndTakesAngularMomentumAlong) {
  const double step = 10.0 * stable_step();
  const Scene scene = spinning_block(Integrator::kBackwardEuler, step, 40 * step);
  Session session(scene, block_of(scene));
  double last = session.balance().energies().total();
  while (session.step()) {
    const double now = session.balance().energies().total();
    EXPECT_LT(now, last);
    last = now;
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(session.balance().max_relative_energy_drift(), 0.1);
  EXPECT_GT(session.balance().angular_momentum_drift(), 1e-3);
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-8);
}

TEST(Reversal, VerletAndMidpointComeBack) {
  for (const Integrator integrator : {Integrator::kVerlet, Integrator::kMidpoint}) {
    const double step = (integrator == Integrator::kVerlet ? 0.3 : 2.0) * stable_step();
    Scene scene = spinning_block(integrator, step, 200 * step);
    scene.solver.tolerance = 1e-12;
    const TetMesh mesh = block_of(scene);
    const auto system = make_system(scene, mesh);
    const State start = make_initial_state(scene, *system);
    const auto stepper = make_stepper(integrator, scene.solver, *system);
    State state = start;
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(stepper->step(state, step).ok());
    ASSERT_GT((state.position - start.position).norm(), 0.1);
    state.momentum *= -1.0;
    stepper->reset();
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(stepper->step(state, step).ok());
    const double tolerance = integrator == Integrator::kVerlet ? 1e-11 : 1e-8;
    EXPECT_LT((state.position - start.position).norm(), tolerance * start.position.norm())
        << to_string(integrator);
    EXPECT_LT((state.momentum + start.momentum).norm(), 10 * tolerance * start.momentum.norm());
  }
}

TEST(Instability, ExplicitExplodesAboveTheLimitAndSaysWhereAndWhy) {
  const double step = 1.3 * stable_step();
  const Scene scene = spinning_block(Integrator::kExplicit, step, 3000 * step);
  Session session(scene, block_of(scene));
  ASSERT_FALSE(session.warnings().empty());
  EXPECT_NE(session.warnings().front().find("stability limit"), std::string::npos);
  EXPECT_EQ(session.run(), RunStatus::kUnstable);
  EXPECT_NE(session.message().find("step "), std::string::npos);
  EXPECT_NE(session.message().find("element "), std::string::npos);
  EXPECT_NE(session.message().find("stability limit"), std::string::npos);
  EXPECT_TRUE(session.state().position.allFinite());
}

// ½ ω q² with symplectic Euler, realised as the breathing of one free tetrahedron would be
// nonlinear; the limit itself is a statement on the linearised body: a tiny motion at 0.995 h_crit
// stays bounded, at 1.005 h_crit it grows without bound.
TEST(Instability, LimitIsSharpForSmallMotions) {
  for (const auto& [factor, stable] : {std::pair{0.995, true}, std::pair{1.005, false}}) {
    Scene scene = spinning_block(Integrator::kExplicit, 1.0, 1.0);
    scene.initial = {};
    scene.initial.stretch = {1.0 + 1e-7, 1.0, 1.0};
    scene.time.step = 1e-6;
    scene.time.end = 1e-6;
    const double limit = Session(scene, block_of(scene)).initial_limit().critical_step;
    scene.time.step = factor * limit;
    scene.time.end = 4000 * scene.time.step;
    Session session(scene, block_of(scene));
    const double start = session.balance().energies().total();
    double largest = 0.0;
    while (session.step()) {
      largest = std::max(largest, session.balance().energies().total());
    }
    if (stable) {
      EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
    } else {
      EXPECT_EQ(session.status(), RunStatus::kUnstable);
      EXPECT_GT(largest, 5.0 * start);
    }
  }
}

TEST(UserForces, MomentumChangesByExactlyTheImpulse) {
  for (const Integrator integrator : {Integrator::kExplicit, Integrator::kVerlet,
                                      Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    const double step = 0.3 * stable_step();
    Scene scene = spinning_block(integrator, step, 100 * step);
    scene.environment.kind = EnvironmentKind::kGravity;
    ForceSettings force = load(SelectNearest{{0, 0, 0}}, {30.0, -10.0, 5.0});
    force.from = 20 * step;
    force.until = 70 * step;
    scene.force.push_back(force);
    Session session(scene, block_of(scene));
    const Vector3 before = session.balance().momenta().linear;
    const double mass = session.system().total_mass();
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const Vector3 expected =
        before + 50 * step * force.vector + 100 * step * mass * Vector3(0, -9.81, 0);
    const double tolerance = integrator == Integrator::kBackwardEuler ? 1e-8 : 1e-12;
    EXPECT_LT((session.balance().momenta().linear - expected).norm(),
              tolerance * session.balance().momenta().linear_scale)
        << to_string(integrator);
    EXPECT_LT(session.balance().linear_momentum_drift(), tolerance);
    EXPECT_NE(session.balance().external_work(), 0.0);
  }
}

}  // namespace
}  // namespace tetraction
