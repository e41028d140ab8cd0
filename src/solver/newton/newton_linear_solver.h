// The solution of Newton's linear systems with the strategy that is chosen.
#pragma once

#include <memory>
#include <string>

#include "assembled_strategies.h"
#include "linear_solver_choice.h"
#include "linear_strategy.h"
#include "matrix_free_strategy.h"
#include "preconditioned_strategy.h"

namespace tetraction {

/// Finds d ≈ −(∇²Φ)⁻¹∇Φ with one of the methods of LinearSolver, as LinearSolverChoice says. It keeps what it may use
/// again: coarse space, factor, symbolic analysis. A body in parts has no assembled matrix here: "cg" and "factor"
/// are conjugate gradients with a preconditioner of its PreconditionerSource.
class NewtonLinearSolver {
 public:
  /// Throws InputError for a method that cannot be used for the body.
  NewtonLinearSolver(const MechanicalSystem& system, const NewtonOptions& options);

  /// To be called before the first direction of a step, which begins at x.
  void begin_step(const MinimizationProblem& problem, const Vector& x);
  /// Finds a direction. Returns false if no direction was found. The report has the residual at x.
  bool find(const NewtonSystem& system, MinimizerReport& report, NewtonDirection& direction);
  /// To be called if the last direction made no progress. From then on, to the end of the step,
  /// directions are computed in double precision; those of assembled conjugate gradients and of a body in
  /// parts, which always are, to more digits. Returns false if they are already.
  bool refine() { return choice_.refine(); }
  /// LinearStrategy::find_negative_curvature().
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            MinimizerReport& report);
  /// Whether the body is small enough for a further factor of the size of its matrix, or uses one anyway.
  bool affords_factor() const { return choice_.affords_factor(); }
  /// To be called after a step that converged in this number of iterations.
  void end_step(int newton_iterations) { choice_.end_step(newton_iterations); }
  /// Takes the method without a matrix from now on, if the choice was left to this object and the
  /// body allows it. For callers whose matrices change too fast for a factor to last.
  void leave_factor() { choice_.leave_factor(); }
  /// The current method: "matrix-free", "cg" or "factor", with an addition for a body in parts.
  std::string name() const;
  /// FactorStrategy::solve_exactly().
  bool solve_exactly(const MinimizationProblem& problem, const Vector& x, const Matrix& right,
                     Matrix& solution) {
    return factor_.solve_exactly(problem, x, right, solution);
  }

 private:
  LinearStrategy& strategy(bool with_matrix);

  const MechanicalSystem& system_;
  LinearSolverChoice choice_;
  MatrixFreeStrategy matrix_free_;
  FactorStrategy factor_;
  DiagonalStrategy diagonal_;
  std::unique_ptr<PreconditionedStrategy> preconditioned_;  // of a body in parts
  double coefficient_sum_ = 0.0;
};

}  // namespace tetraction
