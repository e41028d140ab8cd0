// Implicit steps that the tests of the minimisers share.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "support/assembled.h"
#include "support/bodies.h"
#include "support/messages.h"
#include "tetraction/dynamics/problems/step_problem.h"

namespace tetraction::testing_support {

constexpr double kStep = 0.02;

/// Holds the end at x = 0.
inline void clamp_under_gravity(MechanicalSystem& system, double gravity = 9.81) {
  system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
  system.set_environment(Environment::uniform({0.0, -gravity, 0.0}));
}

/// Velocities that bend, stretch and turn a clamped body within a step.
inline State bending_state(const MechanicalSystem& system) {
  State state = system.rest_state();
  Vector velocity(system.dof_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 x = system.mesh().vertices[static_cast<std::size_t>(v)];
    velocity.segment<3>(3 * v) = x.x() * Vector3(0.5, -4.0, 2.0 * x.y());
  }
  system.set_velocity(state, velocity);
  return state;
}

/// Sets the origin to zero, so that the problem's displacements are the positions themselves.
inline void measure_from_zero(StepProblem& problem) {
  problem.set_origin(Vector::Zero(problem.system().dof_count()));
}

/// Begins the step to time h from `state`, with positions as the unknowns; α = 1 is backward Euler.
inline void begin(StepProblem& problem, const State& state, double h = kStep, double alpha = 1.0) {
  problem.begin(state, h, h, alpha, {});
  measure_from_zero(problem);
}

/// The bending step of a clamped block under gravity.
struct BendingBlock {
  BendingBlock() {
    clamp_under_gravity(system);
    state = bending_state(system);
    begin(problem, state);
  }
  MechanicalSystem system{small_block(), all_materials()[1], 1000.0};
  State state;
  StepProblem problem{system};
};

/// Strains of 1e-9. Beside a constant of 0.1 μ, such elastic energies are below round-off.
struct StiffBlock {
  StiffBlock() {
    clamp_under_gravity(system, 1e-3);
    begin(problem, system.rest_state(), 0.1);
  }
  MechanicalSystem system{small_block(), NeoHookean(8e10, 1.2e11), 7800.0};
  StepProblem problem{system};
};

/// The Hessian over the free coordinates as a dense matrix.
inline Matrix dense_hessian(const StepProblem& problem, const Vector& x) {
  const SparsityPattern pattern(problem.system().rest(), problem.system().coordinates());
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()));
  HessianBlocks terms;
  problem.term_hessian(x, HessianForm::kExact, terms);
  EXPECT_TRUE(problem.hessian(x, terms, pattern, values.data()).ok());
  return dense_matrix(pattern, values);
}

/// Expects that once a residual has fallen below 1e-2 of the force scale, the next one is its square, up to a
/// constant, until round-off.
inline void expect_quadratic_convergence(const std::vector<double>& residuals, double scale) {
  const double floor = 1e-11 * scale;
  int squared = 0;
  for (std::size_t i = 0; i + 1 < residuals.size(); ++i) {
    const double relative = residuals[i] / scale;
    if (relative > 1e-2 || residuals[i] < floor) continue;
    EXPECT_LT(residuals[i + 1], std::max(20.0 * relative * relative * scale, floor));
    ++squared;
  }
  EXPECT_GE(squared, 1);
  EXPECT_LT(residuals.back(), floor);
}

/// The minimiser by Newton's method with a dense factor of the assembled Hessian and step halving.
inline Vector dense_newton(const StepProblem& problem, Vector x) {
  for (int iteration = 0; iteration < 50; ++iteration) {
    double phi = 0.0;
    Vector gradient;
    EXPECT_TRUE(problem.value_and_gradient(x, phi, gradient).ok());
    if (gradient.norm() < 1e-12 * problem.residual_limit(x, 0.5)) break;
    const Vector step =
        problem.system().coordinates().extend(dense_hessian(problem, x).ldlt().solve(-gradient));
    double length = 1.0;
    double trial = 0.0;
    while (!problem.value(x + length * step, trial).ok() || trial > phi + 1e-12 * std::abs(phi)) {
      length *= 0.5;
      if (length < 1e-6) break;
    }
    x += length * step;
  }
  return x;
}

}  // namespace tetraction::testing_support
