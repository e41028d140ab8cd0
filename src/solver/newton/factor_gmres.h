// Newton directions of unsymmetric systems by GMRES with a factor.
#pragma once

#include "core/gmres.h"
#include "line_search.h"
#include "solver/linear/assembled_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// Applies ∂r/∂u over the free coordinates.
class Derivative {
 public:
  void multiply(const RootProblem& problem, const Vector& y, Vector& product) {
    const FreeCoordinates& coordinates = problem.coordinates();
    problem.multiply(coordinates.extend(y), full_);
    product = coordinates.restrict(full_);
  }

 private:
  Vector full_;  // work space, 3 per vertex
};

/// Solves (∂r/∂u) d = −r by GMRES with a kept factor as its preconditioner.
class FactorGmres {
 public:
  explicit FactorGmres(const MechanicalSystem& system) : matrix_(system) {}

  /// direction ≈ −(∂r/∂u)⁻¹ r at a point, to a relative residual of `forcing`.
  bool find(const RootProblem& problem, const Iterate& at, double forcing, MinimizerReport& report,
            Vector& direction) {
    // With a factor of the same matrix GMRES takes a few iterations, one for each unsymmetric part.
    constexpr int kMany = 20;
    constexpr int kMost = 200;
    if (matrix_is_stale_ || !matrix_.has_factor()) {
      if (!factorize(problem, at, report)) return false;
    }
    GmresReport solved =
        solve(problem, at, forcing, factor_is_old_ ? kMany : kMost, report, direction);
    if (!solved.converged && factor_is_old_) {
      if (!factorize(problem, at, report)) return false;
      solved = solve(problem, at, forcing, kMost, report, direction);
    }
    return direction.allFinite() && solved.reduction < 1.0;
  }
  /// A new factor may give a direction of more digits.
  bool refine() {
    if (!factor_is_old_) return false;
    matrix_is_stale_ = true;
    return true;
  }
  /// To be called when the point moves.
  void move() { factor_is_old_ = true; }

 private:
  bool factorize(const RootProblem& problem, const Iterate& at, MinimizerReport& report) {
    const MinimizationProblem& approximation = problem.approximation();
    ++report.factorizations;
    matrix_is_stale_ = true;
    if (!matrix_.assemble(approximation, at.u)) return false;
    if (!matrix_.factorize()) {
      ++report.factorizations;
      if (!matrix_.factorize_projected(approximation, at.u)) return false;
    }
    matrix_is_stale_ = factor_is_old_ = false;
    return true;
  }

  GmresReport solve(const RootProblem& problem, const Iterate& at, double forcing, int most,
                    MinimizerReport& report, Vector& direction) {
    const FreeCoordinates& coordinates = problem.coordinates();
    const GmresReport solved = gmres(
        -coordinates.restrict(at.force),
        [&](const Vector& y, Vector& product) { derivative_.multiply(problem, y, product); },
        [&](const Vector& y, Vector& z) { z = matrix_.back_solve(y); }, forcing, most, free_);
    report.cg_iterations += solved.iterations;
    direction = coordinates.extend(free_);
    return solved;
  }

  AssembledSystem matrix_;
  bool matrix_is_stale_ = true;
  bool factor_is_old_ = false;  // it belongs to another point
  Vector free_;                 // the direction over the free coordinates
  Derivative derivative_;
};

}  // namespace tetraction
