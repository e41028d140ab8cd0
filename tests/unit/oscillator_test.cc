// The closed forms of an oscillator against steps of a body on springs.
#include "tetraction/dynamics/steppers/oscillator.h"

#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A tetrahedron whose four vertices are held by equal springs: a translation of the whole body is
// a mode of ω² = 2γ/m. Three successive displacements give r and θ of a step, since
// u₂ = 2r cos θ u₁ − r² u₀.
OscillatorResponse measured(Integrator rule, double step, double& omega_h) {
  const LameParameters lame = lame_from_young(1e5, 0.3);
  const TetMesh mesh = generate_tetrahedron(1.0);
  MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
  PrescribedVertices springs = prescribe_at_rest(mesh, select_vertices(mesh, SelectAll{}), "all");
  springs.penalty = 500.0;
  system.set_constraints(Constraints({{springs}, {}, {}, {}}, mesh, system.mass()));
  omega_h = step * std::sqrt(2.0 * springs.penalty / system.mass()[0]);
  SolverSettings solver;
  solver.tolerance = 1e-12;
  const auto stepper = make_stepper(rule, solver, system);
  State state = system.rest_state();
  const Vector rest = state.position;
  for (Index v = 0; v < mesh.vertex_count(); ++v) state.position[3 * v] += 0.01;
  std::vector<double> u{0.01};
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(stepper->step(state, step).ok());
    u.push_back(state.position[0] - rest[0]);
  }
  // u₂ = a u₁ − b u₀ and u₃ = a u₂ − b u₁.
  const double determinant = u[0] * u[2] - u[1] * u[1];
  const double a = (u[0] * u[3] - u[1] * u[2]) / determinant;
  const double b = (u[1] * u[3] - u[2] * u[2]) / determinant;
  const double r = std::sqrt(b);
  const double angle = std::acos(a / (2.0 * r));
  return {true, omega_h / angle - 1.0, -std::log(r) / angle,
          std::pow(r, 2.0 * std::numbers::pi / angle)};
}

class Oscillator : public testing::TestWithParam<Integrator> {};

INSTANTIATE_TEST_SUITE_P(All, Oscillator, testing::ValuesIn(all_integrators()));

TEST_P(Oscillator, ClosedFormsAreThoseOfTheSteppers) {
  for (const double step : {0.05, 0.2, 0.35}) {
    double omega_h = 0.0;
    const OscillatorResponse steps = measured(GetParam(), step, omega_h);
    const OscillatorResponse formula = oscillator_response(GetParam(), omega_h);
    EXPECT_TRUE(formula.is_stable);
    EXPECT_NEAR(formula.period_error, steps.period_error, 1e-6) << omega_h;
    EXPECT_NEAR(formula.damping_ratio, steps.damping_ratio, 1e-6) << omega_h;
    EXPECT_NEAR(formula.amplitude_left, steps.amplitude_left, 1e-6) << omega_h;
  }
}

TEST_P(Oscillator, ResolvesUpToTheErrorThatIsAllowed) {
  const double limit = resolved_omega_h(GetParam(), 0.1, 0.1);
  const auto good = [&](double omega_h) {
    const OscillatorResponse response = oscillator_response(GetParam(), omega_h);
    return response.is_stable && std::abs(response.period_error) < 0.1 &&
           response.amplitude_left > 0.9;
  };
  EXPECT_TRUE(good(0.999 * limit));
  EXPECT_FALSE(good(1.001 * limit));
}

TEST(OscillatorLimits, ExplicitRulesAreUnstableFromTwoOn) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    EXPECT_TRUE(oscillator_response(rule, 1.999).is_stable);
    EXPECT_FALSE(oscillator_response(rule, 2.0).is_stable);
  }
  EXPECT_TRUE(oscillator_response(Integrator::kMidpoint, 1e6).is_stable);
  EXPECT_TRUE(oscillator_response(Integrator::kBackwardEuler, 1e6).is_stable);
}

}  // namespace
}  // namespace tetraction
