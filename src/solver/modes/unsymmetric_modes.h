// Small motions with a stiffness that is not symmetric.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <functional>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

struct ComplexEigenpair {
  std::complex<double> value;
  Eigen::VectorXcd vector;  ///< of the length 1
};

/// The eigenpairs with the lowest real parts of a matrix A near a symmetric one, by Davidson's method (E. R.
/// Davidson, J. Comput. Phys. 17, 1975): eigenvectors are sought in a space that grows by the
/// corrections S⁻¹r of their residuals r.
///
/// `product`: z ↦ A z. `solve`: r ↦ S⁻¹ r with a nonsingular S near A. `start`: columns that span the
/// first space, `count` or more, such as the lowest eigenvectors of S. A complex eigenvalue comes with its
/// conjugate, so that there may be one pair more than `count`. Throws Error if the
/// iterations do not converge.
std::vector<ComplexEigenpair> lowest_unsymmetric(
    const std::function<Vector(const Vector&)>& product,
    const std::function<Vector(const Vector&)>& solve, const Matrix& start, Index count);

}  // namespace tetraction
