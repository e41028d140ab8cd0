// Damping never gives energy: with every rule, at any step and any viscosity.
#include <cmath>

#include "support/corner_scenes.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A clamped beam that is struck, with a viscosity up to far beyond what the step resolves.
Scene struck_beam(Integrator integrator, double viscosity, double step) {
  Scene scene = clamped_beam({4, 1, 1}, {8, 2, 2});
  scene.damping.viscosity = viscosity;
  scene.initial.velocity = {0.5, 1.0, 0.0};
  scene.time = {integrator, step, false, 2.0};
  return scene;
}

class ViscousBeam : public testing::TestWithParam<RuleWithSolver> {};

TEST_P(ViscousBeam, LosesEnergyInEveryStepAndBooksAllOfIt) {
  for (const double viscosity : {1e4, 1e6, 1e7}) {
    for (const double step : {0.02, 0.2}) {
      Scene scene = struck_beam(GetParam().integrator, viscosity, step);
      scene.solver = GetParam().solver;
      Session session(scene, mesh_of(scene));
      const double start = session.balance().energies().total();
      double before = 0.0;
      while (session.step()) {
        const double dissipated = session.balance().dissipated_energy();
        EXPECT_GE(dissipated, before) << viscosity << " Pa s, " << step << " s";
        before = dissipated;
      }
      ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
      EXPECT_LT(session.balance().energies().total(), start);
      if (GetParam().integrator == Integrator::kMidpoint && viscosity > 1e5) {
        // The midpoint rule adds far less energy than the viscosity takes.
        EXPECT_LT(std::abs(session.balance().energy_error()), 1e-3 * start)
            << viscosity << " Pa s, " << step << " s";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ViscousBeam, testing::ValuesIn(implicit_rules_with_solvers()),
                         name_with_solver);

// Steps that resolve the motion: all that is dissipated agrees with a fine explicit run to second
// order.
TEST(MidpointViscosity, SecondOrderWhereTheStepResolvesTheMotion) {
  const auto dissipated = [](Integrator integrator, double step) {
    const Scene scene = struck_beam(integrator, 1e4, step);
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return session.balance().dissipated_energy();
  };
  const double exact = dissipated(Integrator::kVerlet, 5e-5);
  const double coarse = std::abs(dissipated(Integrator::kMidpoint, 0.02) - exact);
  const double fine = std::abs(dissipated(Integrator::kMidpoint, 0.01) - exact);
  EXPECT_LT(coarse, 1e-3 * exact);
  EXPECT_LT(fine, coarse / 3.0);
}

// An overdamped body comes to the right rest: what is left after 2 s is the slow creep, 0.530 J with
// steps ten times as short.
TEST(MidpointViscosity, OverdampedBodyKeepsNoSpuriousStress) {
  const Scene scene = struck_beam(Integrator::kMidpoint, 1e7, 0.002);
  FinishedRun session(scene);
  EXPECT_NEAR(session.balance().energies().total(), 0.530, 0.001);
}

class ExplicitDamping : public testing::TestWithParam<Integrator> {};

TEST_P(ExplicitDamping, TakesEnergyInEveryStep) {
  Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
  scene.material.youngs_modulus = 1e5;
  scene.damping = {3.0, 0.5, 500.0};
  scene.initial.velocity = {0.5, 1.0, 0.0};
  scene.time = {GetParam(), 2e-3, false, 1.0};
  Session session(scene, mesh_of(scene));
  double before = 0.0;
  while (session.step()) {
    EXPECT_GE(session.balance().dissipated_energy(), before);
    before = session.balance().dissipated_energy();
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(before, 100.0);
}

// Far above the stability limit of the damping a step would turn velocities around and give energy.
TEST_P(ExplicitDamping, NegativeDissipationIsAFailedStep) {
  Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
  scene.material.youngs_modulus = 1e5;
  scene.damping.mass_damping = 1e4;
  scene.initial.velocity = {0.5, 1.0, 0.0};
  scene.time = {GetParam(), 1e-3, false, 1.0};
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.run(), RunStatus::kUnstable);
  EXPECT_GE(session.balance().dissipated_energy(), 0.0);
  EXPECT_NE(session.message().find("damping"), std::string::npos) << session.message();
}

INSTANTIATE_TEST_SUITE_P(Rules, ExplicitDamping,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet),
                         [](const auto& test) { return to_string(test.param); });

}  // namespace
}  // namespace tetraction
