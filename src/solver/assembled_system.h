// Newton's linear systems with the assembled matrix: conjugate gradients with its diagonal or with
// CHOLMOD's factor of an older matrix.
#pragma once

#include <memory>
#include <vector>

#include "matrix_free_cg.h"
#include "sparse_cholesky.h"
#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// ∇²Φ over the free coordinates in the fixed sparsity pattern, and CHOLMOD's factor.
class AssembledSystem {
 public:
  explicit AssembledSystem(const MechanicalSystem& system);

  /// Assembles the exact Hessian at x; false if Φ is not defined there.
  bool assemble(const StepProblem& problem, const Vector& x);
  /// The same with every element's share of Φ clamped to a positive semidefinite matrix.
  void assemble_projected(const StepProblem& problem, const Vector& x);
  /// The factor of the matrix as it is; false if it is not positive definite.
  bool factorize();
  bool has_factor() const { return has_factor_; }
  /// With the factor, of an older matrix or not, unless its numbers were released.
  Vector back_solve(const Vector& right) { return cholesky_.solve(right); }
  /// The factor in single precision: less than half the memory to read in a solve.
  SinglePrecisionFactor& single_precision_factor();
  /// Frees the numbers of the factor in double precision: two thirds of the memory of both.
  void release_double_precision() { cholesky_.release_factor(); }

  /// After factorize() failed: the factor of the matrix that assemble_projected() makes, to
  /// precondition with; the matrix itself stays. False if that failed as well.
  bool factorize_projected(const StepProblem& problem, const Vector& x);
  /// Factorises the Hessian at x. Where it is not positive definite, looks for a direction of negative
  /// curvature by conjugate gradients on a pseudo-random right-hand side, preconditioned by the
  /// projected factor. Nothing is found where Φ is not defined or the matrix is semidefinite.
  NegativeCurvature find_negative_curvature(const StepProblem& problem, const Vector& x);

  enum class Preconditioner { kDiagonal, kSinglePrecisionFactor, kFactor };
  /// solution ≈ A⁻¹ right to a relative residual of `forcing`, |r|₂/|right|₂.
  CgReport solve(const Vector& right, Preconditioner preconditioner, double forcing,
                 int max_iterations, Vector& solution);
  /// After a solve that met negative curvature: the direction, whose length says nothing.
  NegativeCurvature negative_curvature() const;

  Index size() const { return pattern_.size(); }
  Index nonzeros() const { return pattern_.nonzeros(); }
  const CholeskyCost& cost() { return cholesky_.cost(); }

 private:
  void multiply(const Vector& x, Vector& y) const;

  const FreeCoordinates& coordinates_;
  SparsityPattern pattern_;
  SparseCholesky cholesky_;
  std::vector<double> values_;
  Vector residual_;  // of the last solve
  Vector curved_direction_;
  double curvature_ = 0.0;
  SinglePrecisionFactor single_;
  bool has_factor_ = false;
  bool has_single_ = false;
};

}  // namespace tetraction
