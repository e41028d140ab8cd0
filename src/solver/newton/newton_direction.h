// The linear systems of Newton's method, and the choice of how to solve them.
#pragma once

#include <memory>
#include <string>

#include "preconditioned_direction.h"
#include "solver/linear/assembled_system.h"
#include "solver/linear/matrix_free_cg.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {

/// Finds d ≈ −(∇²Φ)⁻¹∇Φ with one of the methods of LinearSolver. With kAuto it changes the method
/// by rules that count work at fixed prices. It keeps what it may use again: coarse space, factor,
/// symbolic analysis. A body in parts has no assembled matrix here: "cg" and "factor" are conjugate gradients
/// with a preconditioner of its PreconditionerSource.
class NewtonDirection {
 public:
  /// Throws InputError for a method that cannot be used for the body.
  NewtonDirection(const MechanicalSystem& system, const NewtonOptions& options);

  /// To be called before the first direction of a step, which begins at x.
  void begin_step(const MinimizationProblem& problem, const Vector& x);
  /// Finds a direction d with |Tᵀ(∇²Φ d + ∇Φ)| ≤ forcing |Tᵀ∇Φ|. `gradient` is ∇Φ(x), 3 per vertex.
  /// Returns false if no direction was found.
  bool find(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
            double forcing, MinimizerReport& report, Vector& direction);
  /// To be called if the last direction made no progress. From then on, to the end of the step,
  /// directions are computed in double precision; those of assembled conjugate gradients and of a body in
  /// parts, which always are, to more digits. Returns false if they are already.
  bool refine();
  /// The direction of negative curvature that the last find() met. Mostly there is none.
  const NegativeCurvature& negative_curvature() const { return curvature_; }
  /// Whether the last find() factorised ∇²Φ(x) itself. If so, it is positive definite.
  bool is_definite() const { return definite_; }
  /// Looks for a direction of negative curvature at x. If none is found, ∇²Φ(x) is positive
  /// semidefinite.
  ///
  /// A factorisation gives an exact answer, up to round-off. Otherwise conjugate gradients are run
  /// on a pseudo-random right-hand side b. As long as they meet no negative curvature, the
  /// component of their residual along an eigenvector with a negative eigenvalue never shrinks. So
  /// once the residual is 0.01/√n of b, there is no such eigenvector, unless b is nearly orthogonal
  /// to it. For a random b this has a probability below 1 % (compare Royer, O'Neill & Wright 2020,
  /// Assumption 3).
  bool find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                               MinimizerReport& report);
  /// Whether the body is small enough for a further factor of the size of its matrix, or uses one anyway.
  bool affords_factor() const { return system_.part() == nullptr && !prefers_double_cg(); }
  /// Whether it is known that no element is inverted on the way along the last direction.
  bool is_safe() const { return safe_; }
  /// To be called after a step that converged in this number of iterations.
  void end_step(int newton_iterations);
  /// Takes the method without a matrix from now on, if the choice was left to this object and the
  /// body allows it. For callers whose matrices change too fast for a factor to last.
  void leave_factor();
  /// The current method: "matrix-free", "cg" or "factor", with an addition for a body in parts.
  std::string name() const;
  /// Solves ∇²Φ(x) S = `right` over the free coordinates. Returns false if ∇²Φ is not positive
  /// definite.
  bool solve_exactly(const MinimizationProblem& problem, const Vector& x, const Matrix& right,
                     Matrix& solution);

 private:
  struct Prices;

  void prepare_parts();
  bool without_matrix(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
                      double forcing, MinimizerReport& report, Vector& direction);
  bool with_preconditioner(const MinimizationProblem& problem, const Vector& x,
                           const Vector& gradient, double forcing, MinimizerReport& report,
                           Vector& direction);
  bool with_diagonal(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
                     double forcing, MinimizerReport& report, Vector& direction);
  bool with_factor(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
                   double forcing, MinimizerReport& report, Vector& direction);
  bool by_elements(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
                   double forcing, MinimizerReport& report, Vector& direction);
  bool probe_by_elements(const MinimizationProblem& problem, const Vector& x,
                         MinimizerReport& report);
  void take_true_curvature();
  bool with_exact_factor(const MinimizationProblem& problem, const Vector& x,
                         const Vector& gradient, MinimizerReport& report, Vector& direction);
  bool with_kept_factor(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
                        double forcing, MinimizerReport& report, Vector& direction);
  template <class Cg>
  CgReport solve_without_matrix(Cg& cg, const MinimizationProblem& problem, const Vector& x,
                                const Vector& gradient, double forcing, int most,
                                Vector& direction);
  bool is_true_curvature(const MinimizationProblem& problem, const Vector& x);
  bool probe_without_matrix(const MinimizationProblem& problem, const Vector& x,
                            MinimizerReport& report);
  bool probe_matrix(const MinimizationProblem& problem, const Vector& x, MinimizerReport& report);
  AssembledSystem& assembled();
  MatrixFreeCg<float>& single_precision_cg();
  MatrixFreeCg<double>& double_precision_cg();
  Prices rough_prices() const;
  bool prefers_double_cg() const;
  bool counts_costs() const;

  const MechanicalSystem& system_;
  NewtonOptions options_;
  bool can_do_without_matrix_;
  LinearSolver current_;
  Index unknowns_;  // of the whole body
  std::unique_ptr<MatrixFreeCg<float>> single_;
  std::unique_ptr<MatrixFreeCg<double>> double_;
  std::unique_ptr<AssembledSystem> assembled_;
  std::unique_ptr<PreconditionedDirection> preconditioned_;  // of a body in parts
  bool single_precision_ = true;         // it is sufficient for the matrix-free method
  bool single_precision_factor_ = true;  // it is sufficient for the factor as a preconditioner
  bool refined_ = false;                 // directions of this step are in double precision
  bool safe_ = false;
  bool definite_ = false;
  NegativeCurvature curvature_;  // of the last find()
  Vector right_;                 // of the search for it
  Vector ignored_;
  bool stale_ = false;   // the factor must be renewed
  double regret_ = 0.0;  // work that another choice would have saved
  double cost_of_step_ = 0.0;
  double coefficient_sum_ = 0.0;
  // The change of kAuto to the factor where Newton's method makes slow progress.
  int slow_ = 0;  // iterations of this step that met negative curvature or gained little
  double last_residual_ = 0.0;
  bool for_this_step_ = false;
  int visits_ = 0;
};

}  // namespace tetraction
