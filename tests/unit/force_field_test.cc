#include "tetraction/dynamics/terms/force_field.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

using namespace testing_support;

// U = ½ m Ω² R² ln(1 + (x² + y²)/R²) + ½ k z²: a trap around the z axis whose pull along z does not
// depend on the mass.
class Trap : public ForceField {
 public:
  double value(double mass, const Vector3& q) const override {
    return 0.5 * mass * kRate * kRate * kRadius * kRadius *
               std::log1p(q.head<2>().squaredNorm() / (kRadius * kRadius)) +
           0.5 * kSpring * q.z() * q.z();
  }
  Vector3 gradient(double mass, const Vector3& q) const override {
    const double k = pull(mass, q);
    return {k * q.x(), k * q.y(), kSpring * q.z()};
  }
  Matrix3 hessian(double mass, const Vector3& q) const override {
    const double k = pull(mass, q);
    const Vector3 r(q.x(), q.y(), 0.0);
    Matrix3 hessian = Vector3(k, k, kSpring).asDiagonal();
    hessian -= 2.0 * k * k / (mass * kRate * kRate * kRadius * kRadius) * r * r.transpose();
    return hessian;
  }

 private:
  static constexpr double kRate = 3.0;    // 1/s
  static constexpr double kRadius = 1.5;  // m
  static constexpr double kSpring = 7.0;  // N/m
  static double pull(double mass, const Vector3& q) {
    return mass * kRate * kRate / (1.0 + q.head<2>().squaredNorm() / (kRadius * kRadius));
  }
};

TEST(ForceField, IsWhatTheEnvironmentSays) {
  const auto trap = std::make_shared<Trap>();
  const Environment environment = Environment::custom(trap);
  EXPECT_FALSE(environment.is_uniform());
  EXPECT_FALSE(environment.is_singular());
  const Vector3 q(0.3, -2.5, 0.8);
  EXPECT_EQ(environment.value(2.0, q), trap->value(2.0, q));
  EXPECT_EQ(environment.gradient(2.0, q), trap->gradient(2.0, q));
  EXPECT_EQ(environment.hessian(2.0, q), trap->hessian(2.0, q));
  EXPECT_THROW(Environment::custom(nullptr), InputError);
}

TEST(ForceField, DerivativesThroughTheEnvironment) {
  const Environment environment = Environment::custom(std::make_shared<Trap>());
  const double h = 1e-5;
  for (const Vector3& q : {Vector3(0.3, -0.5, 0.8), Vector3(-4.0, 1.0, 0.1)}) {
    for (const double mass : {0.4, 2.5}) {
      for (int i = 0; i < 3; ++i) {
        const Vector3 e = h * Vector3::Unit(i);
        const double slope =
            (environment.value(mass, Vector3(q + e)) - environment.value(mass, Vector3(q - e))) /
            (2.0 * h);
        EXPECT_NEAR(environment.gradient(mass, q)[i], slope, 1e-7);
        const Vector3 bend =
            (environment.gradient(mass, q + e) - environment.gradient(mass, q - e)) / (2.0 * h);
        EXPECT_LT((environment.hessian(mass, q).col(i) - bend).norm(), 1e-7);
      }
    }
  }
}

// A hill: U falls below zero from the first step on, and its second derivative is negative.
class Hill : public ForceField {
 public:
  double value(double mass, const Vector3& q) const override {
    return -0.5 * mass * 25.0 * q.squaredNorm();
  }
  Vector3 gradient(double mass, const Vector3& q) const override { return -25.0 * mass * q; }
  Matrix3 hessian(double mass, const Vector3&) const override {
    return -25.0 * mass * Matrix3::Identity();
  }
};

// Down a hill every point goes as cosh(ωt): the centre of mass does, and the body is torn wider.
TEST(ForceField, ARepellingOneIsSteppedImplicitly) {
  const LameParameters lame = lame_from_young(1e6, 0.3);
  MechanicalSystem system(small_block({2, 1, 1}), NeoHookean(lame.mu, lame.lambda), 1000.0);
  system.set_environment(Environment::custom(std::make_shared<Hill>()));
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    const auto stepper = make_stepper(integrator, {}, system);
    State state = system.rest_state();
    const Vector3 start = center_of_mass(system, state.position);
    for (int k = 0; k < 100; ++k) {
      const StepOutcome outcome = stepper->step(state, 2e-3);
      ASSERT_TRUE(outcome.ok()) << outcome.message;
    }
    const Vector3 exact = std::cosh(5.0 * 0.2) * start;
    EXPECT_LT((center_of_mass(system, state.position) - exact).norm(),
              (integrator == Integrator::kMidpoint ? 1e-4 : 0.01) * exact.norm());
  }
}

TEST(ForceField, OfAllVerticesIsTheSum) {
  const Environment environment = Environment::custom(std::make_shared<Trap>());
  const MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  const Vector q = jiggled(system.rest_state().position, 0.1);
  Vector gradient = Vector::Ones(q.size());
  environment.add_gradient(system.force_point(q, 0.0), gradient);
  double energy = 0.0;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 x = q.segment<3>(3 * v);
    energy += environment.value(system.mass()[v], x);
    EXPECT_LT(
        (gradient.segment<3>(3 * v) - Vector3::Ones() - environment.gradient(system.mass()[v], x))
            .norm(),
        1e-10);
  }
  EXPECT_NEAR(environment.energy(system.force_point(q, 0.0)), energy, 1e-12 * energy);
}

class ForceFieldSteps : public testing::TestWithParam<Integrator> {};

INSTANTIATE_TEST_SUITE_P(Rules, ForceFieldSteps,
                         testing::Values(Integrator::kExplicit, Integrator::kVerlet,
                                         Integrator::kMidpoint),
                         [](const auto& rule) { return to_string(rule.param); });

// With half the step the error of the energy falls as the order says, and the spin about the axis,
// which the trap leaves alone, is kept.
TEST_P(ForceFieldSteps, TheBooksClose) {
  const LameParameters lame = lame_from_young(1e5, 0.3);
  MechanicalSystem system(small_block({2, 1, 1}), NeoHookean(lame.mu, lame.lambda), 1000.0);
  system.set_environment(Environment::custom(std::make_shared<Trap>()));
  SolverSettings solver;
  solver.tolerance = 1e-12;
  const auto drift = [&](double h) {
    const auto stepper = make_stepper(GetParam(), solver, system);
    State state = system.rest_state();
    system.set_velocity(state, Vector3(0.5, 2.0, -1.0).replicate(system.vertex_count(), 1));
    Balance balance(system, state);
    const double spin = balance.momenta().angular.z();
    double smallest = balance.energies().environment();
    double largest = smallest;
    for (double t = 0.0; t < 1.0 - 0.5 * h; t += h) {
      const StepOutcome outcome = stepper->step(state, h);
      EXPECT_TRUE(outcome.ok()) << outcome.message;
      balance.enter(state, outcome);
      smallest = std::min(smallest, balance.energies().environment());
      largest = std::max(largest, balance.energies().environment());
    }
    EXPECT_GT(largest - smallest, 0.2 * balance.energy_scale());  // the trap has taken part
    EXPECT_LT(balance.linear_momentum_drift(), 1e-9);
    EXPECT_LT(balance.angular_momentum_drift(), 1e-9);
    EXPECT_NEAR(balance.momenta().angular.z(), spin, 1e-9 * std::abs(spin));
    return balance.max_relative_energy_drift();
  };
  const double coarse = drift(2e-3);
  const double fine = drift(1e-3);
  EXPECT_LT(coarse, order(GetParam()) == 2 ? 1e-3 : 0.05);
  EXPECT_NEAR(coarse / fine, std::pow(2.0, order(GetParam())),
              0.25 * std::pow(2.0, order(GetParam())));
}

}  // namespace
}  // namespace tetraction
