// Newton's linear systems by conjugate gradients without a matrix.
#pragma once

#include "fem/tangent_operator.h"
#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// How a solve by conjugate gradients ended.
struct CgReport {
  int iterations = 0;
  double reduction = 1.0;           ///< |r|/|b| at the end, in the norm of the preconditioner
  bool negative_curvature = false;  ///< the direction found so far is given
  bool converged = false;
};

/// Conjugate gradients on ∇²Φ(x) in precision T with the tangent stiffness applied element by
/// element, preconditioned by the vertices' 3 × 3 blocks. Directions that constraints take from a
/// vertex are left out by the preconditioner; affine sets (rigid handles) are not supported.
///
/// Single precision is enough: what is wanted of a direction is a few digits, and the residuals of
/// Newton's method are worked out in double precision outside.
template <class T>
class MatrixFreeCg {
 public:
  static bool supports(const MechanicalSystem& system);
  explicit MatrixFreeCg(const MechanicalSystem& system);

  /// Linearises at x, where Φ must be defined.
  void set(const StepProblem& problem, const Vector& x);
  /// step ≈ −(∇²Φ)⁻¹ gradient (3 per vertex) to a relative residual of `forcing`.
  CgReport solve(const Vector& gradient, double forcing, int max_iterations, Vector& step);
  /// Whether no element can be inverted on the way along the last step.
  bool step_is_safe() const { return operator_.step_is_safe(x_.data()); }

 private:
  using Row = Eigen::Matrix<T, 4, 1>;

  void make_preconditioner(const StepProblem& problem);
  Eigen::Map<Row, Eigen::Aligned16> row(AlignedVector<T>& field, Index v) const {
    return Eigen::Map<Row, Eigen::Aligned16>(field.data() + 4 * v);
  }

  const MechanicalSystem& system_;
  TangentOperator<T> operator_;
  bool curved_ = false;
  AlignedVector<T> diagonal_;  // of what belongs to single vertices: rows (xx yy zz 0)
  AlignedVector<T> off_;       // (xy xz yz 0), of curved environments
  AlignedVector<T> inverse_;   // of the vertices' blocks: three rows each
  AlignedVector<T> x_, r_, p_, z_, ap_;
};

extern template class MatrixFreeCg<float>;
extern template class MatrixFreeCg<double>;

}  // namespace tetraction
