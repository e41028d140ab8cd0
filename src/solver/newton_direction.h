// The linear systems of Newton's method, and the choice of how to solve them.
#pragma once

#include <memory>
#include <string>

#include "assembled_system.h"
#include "matrix_free_cg.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {

/// Finds d ≈ −(∇²Φ)⁻¹∇Φ by one of the ways of LinearSolver and, with kAuto, changes the way by rules
/// that count work at fixed prices. Keeps what can serve again: coarse space, factor, analysis.
class NewtonDirection {
 public:
  /// Throws InputError for a way that the body does not allow.
  NewtonDirection(const MechanicalSystem& system, const NewtonOptions& options);

  /// Before the first direction of a step.
  void begin_step(const StepProblem& problem);
  /// `gradient`: ∇Φ(x), 3 per vertex; |Tᵀ(∇²Φ d + ∇Φ)| ≤ forcing |Tᵀ∇Φ|. False if none was found.
  bool find(const StepProblem& problem, const Vector& x, const Vector& gradient, double forcing,
            MinimizerReport& report, Vector& direction);
  /// Whether no element can be inverted on the way along the last direction; false: not known.
  bool is_safe() const { return safe_; }
  /// After a step that converged in so many iterations.
  void end_step(int newton_iterations);
  /// "matrix-free", "cg" or "factor".
  std::string name() const;
  /// Solves ∇²Φ(x) S = `right` over the free coordinates; false if ∇²Φ is not positive definite.
  bool solve_exactly(const StepProblem& problem, const Vector& x, const Matrix& right,
                     Matrix& solution);

 private:
  struct Prices;

  bool without_matrix(const StepProblem& problem, const Vector& x, const Vector& gradient,
                      double forcing, MinimizerReport& report, Vector& direction);
  bool with_diagonal(const StepProblem& problem, const Vector& x, const Vector& gradient,
                     double forcing, MinimizerReport& report, Vector& direction);
  bool with_factor(const StepProblem& problem, const Vector& x, const Vector& gradient,
                   double forcing, MinimizerReport& report, Vector& direction);
  bool with_kept_factor(const StepProblem& problem, const Vector& x, const Vector& gradient,
                        double forcing, MinimizerReport& report, Vector& direction);
  AssembledSystem& assembled();
  MatrixFreeCg<float>& single();
  MatrixFreeCg<double>& twice();
  Prices rough_prices() const;

  const MechanicalSystem& system_;
  NewtonOptions options_;
  bool can_do_without_matrix_;
  LinearSolver current_;
  std::unique_ptr<MatrixFreeCg<float>> single_;
  std::unique_ptr<MatrixFreeCg<double>> double_;
  std::unique_ptr<AssembledSystem> assembled_;
  bool single_precision_ = true;         // is enough without a matrix
  bool single_precision_factor_ = true;  // is enough as a preconditioner
  bool safe_ = false;
  bool stale_ = false;   // the factor is to be made anew
  double regret_ = 0.0;  // work that another choice would have spared
  double cost_of_step_ = 0.0;
  double coefficient_sum_ = 0.0;
};

}  // namespace tetraction
