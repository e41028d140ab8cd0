// Newton directions with the assembled matrix.
#pragma once

#include <memory>

#include "linear_solver_choice.h"
#include "linear_strategy.h"
#include "matrix_free_strategy.h"
#include "solver/linear/assembled_system.h"

namespace tetraction {

/// Solves with CHOLMOD's factor of ∇²Φ, which is kept for later systems as the preconditioner of conjugate
/// gradients until the iterations beyond the third have cost as much as a new one. The products are those of
/// MatrixFreeCg where it supports the body, and of single elements (AssembledSystem::solve_by_elements()) where Φ
/// has no inertia.
class FactorStrategy : public LinearStrategy {
 public:
  /// Without `keep_factor` each system gets a factor of its own. Keeps references to the other arguments.
  FactorStrategy(const MechanicalSystem& system, bool keep_factor, LinearSolverChoice& choice,
                 MatrixFreeStrategy& matrix_free);

  bool find(const NewtonSystem& system, MinimizerReport& report,
            NewtonDirection& direction) override;
  /// The same with a factor of ∇²Φ(x) itself, in double precision, if that is positive definite.
  bool find_exactly(const NewtonSystem& system, MinimizerReport& report,
                    NewtonDirection& direction);
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            MinimizerReport& report) override;
  /// Solves ∇²Φ(x) S = `right` over the free coordinates. Returns false if ∇²Φ is not positive
  /// definite.
  bool solve_exactly(const MinimizationProblem& problem, const Vector& x, const Matrix& right,
                     Matrix& solution);
  /// To be called before systems that differ strongly from the last ones (another step size).
  void forget() { is_stale_ = true; }
  /// The matrix, which is made at the first call.
  AssembledSystem& matrix();

 private:
  bool find_with_kept(const NewtonSystem& system, MinimizerReport& report,
                      NewtonDirection& direction);
  bool find_by_elements(const NewtonSystem& system, MinimizerReport& report,
                        NewtonDirection& direction);
  bool find_projected(const NewtonSystem& system, MinimizerReport& report,
                      NewtonDirection& direction, NegativeCurvature& met);
  NegativeCurvature probe_by_elements(const MinimizationProblem& problem, const Vector& x,
                                      MinimizerReport& report);
  bool has_kept() { return keep_factor_ && matrix().has_factor() && !is_stale_; }
  void enter_factorization();

  const MechanicalSystem& system_;
  bool keep_factor_;
  LinearSolverChoice& choice_;
  MatrixFreeStrategy& matrix_free_;
  std::unique_ptr<AssembledSystem> matrix_;
  bool single_precision_suffices_ = true;  // for the factor as a preconditioner
  bool is_stale_ = false;                  // the factor must be renewed
};

/// Solves by conjugate gradients that are preconditioned with the diagonal.
class DiagonalStrategy : public LinearStrategy {
 public:
  /// Keeps references to all. The matrix is that of `factor`.
  DiagonalStrategy(const MechanicalSystem& system, const LinearSolverChoice& choice,
                   FactorStrategy& factor)
      : system_(system), choice_(choice), factor_(factor) {}

  bool find(const NewtonSystem& system, MinimizerReport& report,
            NewtonDirection& direction) override;
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            MinimizerReport& report) override;

 private:
  const MechanicalSystem& system_;
  const LinearSolverChoice& choice_;
  FactorStrategy& factor_;
};

}  // namespace tetraction
