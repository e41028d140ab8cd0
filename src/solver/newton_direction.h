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
  /// From now on, to the end of the step, directions are worked out in double precision, because the
  /// last one did not help. False if they are already.
  bool refine();
  /// What the last find() met of ∇²Φ(x) not being positive definite; nothing is found in most.
  const NegativeCurvature& negative_curvature() const { return curvature_; }
  /// Whether the last find() factorised ∇²Φ(x) itself: it is positive definite.
  bool is_definite() const { return definite_; }
  /// Looks for a direction of negative curvature at x; with none ∇²Φ(x) is positive semidefinite.
  ///
  /// A factorisation answers exactly, up to round-off. Otherwise conjugate gradients are run on a
  /// pseudo-random right-hand side b. Without a direction of negative curvature the part of their
  /// residual along an eigenvector of a negative eigenvalue never shrinks, so that there is none,
  /// unless b lies nearly across it, once the residual is 0.01/√n of b: with b at random a
  /// probability below 1 % (compare Royer, O'Neill & Wright 2020, Assumption 3).
  bool find_negative_curvature(const StepProblem& problem, const Vector& x,
                               MinimizerReport& report);
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
  bool with_exact_factor(const StepProblem& problem, const Vector& x, const Vector& gradient,
                         MinimizerReport& report, Vector& direction);
  bool with_kept_factor(const StepProblem& problem, const Vector& x, const Vector& gradient,
                        double forcing, MinimizerReport& report, Vector& direction);
  template <class Cg>
  CgReport solve_without_matrix(Cg& cg, const StepProblem& problem, const Vector& x,
                                const Vector& gradient, double forcing, int most,
                                Vector& direction);
  bool is_true_curvature(const StepProblem& problem, const Vector& x);
  bool probe_without_matrix(const StepProblem& problem, const Vector& x, MinimizerReport& report);
  bool probe_matrix(const StepProblem& problem, const Vector& x, MinimizerReport& report);
  AssembledSystem& assembled();
  MatrixFreeCg<float>& single_precision_cg();
  MatrixFreeCg<double>& double_precision_cg();
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
  bool refined_ = false;                 // directions of this step are in double precision
  bool safe_ = false;
  bool definite_ = false;
  NegativeCurvature curvature_;  // of the last find()
  Vector right_;                 // of the search for it
  Vector ignored_;
  bool stale_ = false;   // the factor is to be made anew
  double regret_ = 0.0;  // work that another choice would have spared
  double cost_of_step_ = 0.0;
  double coefficient_sum_ = 0.0;
  // The change of kAuto to the factor where Newton's method makes slow progress.
  int slow_ = 0;  // iterations of this step that met negative curvature or gained little
  double last_residual_ = 0.0;
  bool for_this_step_ = false;
  int visits_ = 0;
};

}  // namespace tetraction
