// Force terms of a user's own with every rule and solver: their energy closes the balance, and closed
// solutions are met.
#include <cmath>

#include "support/force_terms.h"
#include "support/soft_cube.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ForceTerms : public SoftCube {};

INSTANTIATE_TEST_SUITE_P(All, ForceTerms, testing::ValuesIn(rules_with_solvers()),
                         name_with_solver);

// The block falls on a floor, and bounces. What is missing in the balance is what the rule itself adds,
// which falls with its order.
TEST_P(ForceTerms, ABodyBouncesOnAFloorAndTheBalanceCloses) {
  const auto error = [&](double step, double* held) {
    Scene scene = cube(step, 0.24);
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.force_term.push_back(std::make_shared<FloorBarrier>(-0.1, 1e5, 0.02));
    Session session(scene, cube_mesh());
    double largest = 0.0;
    double lowest = 1.0;
    while (session.step()) {
      const Energies& energies = session.balance().energies();
      EXPECT_NEAR(
          energies.total(),
          energies.kinetic() + energies.elastic() + energies.environment() + energies.of("floor"),
          1e-14 * session.balance().energy_scale());
      if (held != nullptr) *held = std::max(*held, energies.of("floor"));
      largest = std::max(largest, std::abs(session.balance().energy_error()));
      for (Index i = 1; i < session.state().position.size(); i += 3) {
        lowest = std::min(lowest, session.state().position[i]);
      }
    }
    EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_GT(lowest, -0.1);
    EXPECT_LT(lowest, -0.083) << "it came well into the barrier, which begins at −0.08";
    // Up again: the impulse of the floor is in the momentum, and nothing else.
    EXPECT_GT(session.balance().momenta().linear.y(), 0.0);
    // The momenta of backward Euler carry the residual that the solver leaves in every step.
    EXPECT_LT(session.balance().linear_momentum_drift(),
              is_variational(GetParam().integrator) ? 1e-11 : 1e-8);
    return largest / session.balance().energy_scale();
  };
  double held = 0.0;
  const double coarse = error(4e-4, &held);
  const double fine = error(1e-4, nullptr);
  EXPECT_GT(held, 0.1);
  if (GetParam().integrator == Integrator::kEnergyMomentum) {
    EXPECT_LT(std::max(coarse, fine), 1e-10);
    return;
  }
  EXPECT_LT(fine, has_second_order() ? 2e-3 : 0.2);
  EXPECT_LT(fine, coarse / (has_second_order() ? 8.0 : 1.8));
}

// A body without elastic deformation slows down as v₀/(1 + c v₀ t).
TEST_P(ForceTerms, DragWithTheSquareOfTheSpeedHasAClosedSolution) {
  constexpr double kDrag = 0.8;
  constexpr double kSpeed = 3.0;
  constexpr double kEnd = 0.5;
  const auto run = [&](double step) {
    Scene scene = cube(step, kEnd);
    scene.initial.velocity = {kSpeed, 0.0, 0.0};
    scene.force_term.push_back(std::make_shared<QuadraticDrag>(kDrag));
    Session session(scene, cube_mesh());
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const double mass = session.system().total_mass();
    const double exact = kSpeed / (1.0 + kDrag * kSpeed * kEnd);
    const double lost = 0.5 * mass * (kSpeed * kSpeed - exact * exact);
    EXPECT_NEAR(session.balance().dissipated_energy(), lost, 2.0 * step * lost);
    return std::abs(session.balance().momenta().linear.x() / mass - exact);
  };
  const double coarse = run(2e-3);
  const double fine = run(1e-3);
  EXPECT_LT(fine, has_second_order() ? 1e-5 : 2e-3);
  // Errors of verlet happen to fall with the third order here.
  EXPECT_GT(coarse / fine, has_second_order() ? 3.7 : 1.9);
}

// Dissipation that depends on the position keeps the order of the rule.
TEST_P(ForceTerms, DragThatDependsOnThePositionKeepsTheOrder) {
  const auto end = [&](double step) {
    Scene scene = cube(step, 0.2);
    scene.initial.velocity = {2.0, 0.0, 0.0};
    scene.force_term.push_back(std::make_shared<LayeredDrag>(4.0, 0.2));
    Session session(scene, cube_mesh());
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return Vector(session.state().position);
  };
  const Vector coarse = end(1e-3);
  const Vector middle = end(5e-4);
  const Vector fine = end(2.5e-4);
  const double ratio = (coarse - middle).norm() / (middle - fine).norm();
  EXPECT_GT(ratio, has_second_order() ? 3.5 : 1.8);
}

// A field that swings moves the body as A(ωt − sin ωt)/ω² from rest, and the work of its change is
// external work.
TEST_P(ForceTerms, APotentialThatDependsOnTimePutsEnergyIn) {
  constexpr double kAcceleration = 5.0;
  constexpr double kOmega = 10.0;
  constexpr double kEnd = 0.4;
  const auto run = [&](double step) {
    Scene scene = cube(step, kEnd);
    scene.force_term.push_back(std::make_shared<SwingingField>(kAcceleration, kOmega));
    Session session(scene, cube_mesh());
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const Balance& balance = session.balance();
    const double mass = session.system().total_mass();
    const double speed = kAcceleration / kOmega * (1.0 - std::cos(kOmega * kEnd));
    EXPECT_NEAR(balance.momenta().linear.x() / mass, speed, 5.0 * step * speed);
    EXPECT_GT(std::abs(balance.energies().of("swing")), 1.0);
    return std::abs(balance.energy_error()) / balance.energies().kinetic();
  };
  const double coarse = run(2e-3);
  const double fine = run(1e-3);
  if (GetParam().integrator == Integrator::kEnergyMomentum) {
    EXPECT_LT(std::max(coarse, fine), 1e-10);
    return;
  }
  EXPECT_LT(fine, has_second_order() ? 1e-4 : 2e-2);
  EXPECT_LT(fine, 0.6 * coarse);
}

// Springs tie vertices that no element connects, in a body that spins.
TEST_P(ForceTerms, SpringsBetweenFarVerticesKeepEnergyAndMomenta) {
  if (GetParam().solver.kind == "ceres") GTEST_SKIP() << "Ceres refuses them";
  Scene scene = cube(5e-4, 0.1);
  scene.initial.angular_velocity = {1.0, 2.0, 3.0};
  const TetMesh mesh = cube_mesh();
  const Index last = mesh.vertex_count() - 1;
  scene.force_term.push_back(std::make_shared<PairSprings>(
      std::vector<std::pair<Index, Index>>{{0, last}, {1, last - 1}}, 2e3, 0.25));
  Session session(scene, mesh);
  double most = 0.0;
  double least = 1e9;
  while (session.step()) {
    const double held = session.balance().energies().of("pair_springs");
    most = std::max(most, held);
    least = std::min(least, held);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(most, 1.2 * least) << "they work";
  EXPECT_LT(session.balance().linear_momentum_drift(), 1e-9);
  // Backward Euler loses energy and angular momentum, as it does without springs.
  if (!is_variational(GetParam().integrator)) return;
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-7);
  EXPECT_LT(session.balance().max_relative_energy_drift(), has_second_order() ? 2e-3 : 0.2);
}

// A step that would go through the floor fails and says why; the state is the last good one.
TEST(UndefinedPotentials, AStepThroughTheFloorIsRefused) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    Scene scene = scene_of(elastic(1e3, 0.3));
    scene.time = {rule, 1e-2, false, 1.0};
    scene.initial.velocity = {0.0, -50.0, 0.0};
    scene.force_term.push_back(std::make_shared<FloorBarrier>(-0.6, 1e3, 0.01));
    Session session(scene, generate_box({0.2, 0.2, 0.2}, {1, 1, 1}));
    EXPECT_EQ(session.run(), RunStatus::kUnstable);
    EXPECT_EQ(session.state().step, 1);
    expect_part(session.message(), "\"floor\" is not defined at vertex");
  }
}

TEST(UndefinedPotentials, ABodyMayNotBeginThere) {
  Scene scene = scene_of(elastic(1e3, 0.3));
  scene.force_term.push_back(std::make_shared<FloorBarrier>(0.1, 1e3, 0.01));
  expect_error(
      [&] {
        Session session(scene, generate_box({0.2, 0.2, 0.2}, {1, 1, 1}));
      },
      {"\"floor\""});
}

// A step that was too large for its damping is repeated with a smaller one, as if it had never been
// tried.
TEST(TermsAndStability, ARepeatedStepKnowsNothingOfTheOneThatFailed) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    Scene scene = scene_of(elastic(5e4, 0.3));
    scene.time = {rule, 1e-3, true, 1.0};
    scene.initial.velocity = {3.0, 0.0, 1.0};
    scene.initial.angular_velocity = {0.0, 20.0, 0.0};
    scene.force_term.push_back(std::make_shared<QuadraticDrag>(400.0));
    const TetMesh mesh = generate_box({0.2, 0.2, 0.2}, {2, 2, 2});
    Session automatic(scene, mesh);
    ASSERT_TRUE(automatic.step()) << automatic.message();
    const double step = automatic.steps().last;
    EXPECT_LT(step, 0.4 * automatic.initial_limit().critical_step) << "a step was repeated";
    scene.time.automatic = false;
    scene.time.step = step;
    Session fixed(scene, mesh);
    ASSERT_TRUE(fixed.step()) << fixed.message();
    EXPECT_EQ(automatic.state().momentum, fixed.state().momentum);
    EXPECT_EQ(automatic.state().position, fixed.state().position);
  }
}

// "auto" makes its steps smaller where a term is as stiff as a floor.
TEST(TermsAndStability, TheLimitKnowsTheirStiffness) {
  Scene scene = scene_of(elastic(1e3, 0.3));
  scene.time = {Integrator::kVerlet, 1e-6, false, 1.0};
  const TetMesh mesh = generate_box({0.2, 0.2, 0.2}, {1, 1, 1});
  const double without = Session(scene, mesh).initial_limit().omega_max;
  const double stiffness = 1e6;
  scene.force_term.push_back(std::make_shared<FloorBarrier>(-5e-3, stiffness, 1e-2));
  const Session session(scene, mesh);
  // At half the thickness b'' = κ (2 ln 2 + 5).
  const double bend = stiffness * (2.0 * std::log(2.0) + 5.0);
  const double lightest = session.system().mass().minCoeff();
  EXPECT_GT(session.initial_limit().omega_max, without);
  EXPECT_NEAR(session.initial_limit().omega_max, std::sqrt(bend / lightest),
              0.02 * std::sqrt(bend / lightest));
}

}  // namespace
}  // namespace tetraction
