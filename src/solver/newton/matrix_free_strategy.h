// Newton directions by conjugate gradients without a matrix.
#pragma once

#include <memory>

#include "linear_solver_choice.h"
#include "linear_strategy.h"
#include "solver/linear/matrix_free_cg.h"

namespace tetraction {

/// Solves with MatrixFreeCg in single precision until its round-off is too large, then in double precision. If
/// ∇²Φ is not positive definite, the direction is that of a modified matrix that nearly is.
class MatrixFreeStrategy : public LinearStrategy {
 public:
  /// Keeps references to both.
  MatrixFreeStrategy(const MechanicalSystem& system, LinearSolverChoice& choice)
      : system_(system), choice_(choice) {}

  /// Returns false if the iterations do not converge and the choice is free to take another method.
  bool find(const NewtonSystem& system, MinimizerReport& report,
            NewtonDirection& direction) override;
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            MinimizerReport& report) override;
  /// To be called before a system with a new matrix.
  void leave_matrix() { linearized_ = nullptr; }
  /// To be called before systems that differ strongly from the last ones (another step size).
  void forget();
  MatrixFreeCg<float>& single_precision();
  /// The same, with the matrix of the system.
  MatrixFreeCg<float>& single_precision(const NewtonSystem& system) {
    linearize(single_precision(), system);
    return *single_;
  }
  /// The right-hand side of a search for negative curvature. Collective.
  const Vector& probing_vector(Index size);

 private:
  MatrixFreeCg<double>& double_precision();
  template <class Cg>
  void linearize(Cg& cg, const NewtonSystem& system) {
    if (linearized_ != &cg) cg.set(system.problem, system.x);
    linearized_ = &cg;
  }
  template <class Cg>
  CgReport solve(Cg& cg, const NewtonSystem& system, int most, NewtonDirection& direction);
  bool is_true(const MinimizationProblem& problem, const Vector& x, NegativeCurvature& curvature);

  const MechanicalSystem& system_;
  LinearSolverChoice& choice_;
  std::unique_ptr<MatrixFreeCg<float>> single_;
  std::unique_ptr<MatrixFreeCg<double>> double_;
  const void* linearized_ = nullptr;  // which of the two has the present matrix, unmodified
  bool single_precision_suffices_ = true;
  Vector probing_vector_;
  Vector ignored_;
};

}  // namespace tetraction
