// Projection of small symmetric matrices to positive semidefinite ones.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The symmetric positive semidefinite matrix that is nearest to the symmetric matrix `a` in the
/// Frobenius norm: its negative eigenvalues are set to zero (Higham 1988). A matrix
/// without negative eigenvalues is returned as it is.
Matrix3 positive_semidefinite_part(const Matrix3& a);
Eigen::Matrix<double, 6, 6> positive_semidefinite_part(const Eigen::Matrix<double, 6, 6>& a);
Matrix positive_semidefinite_part(const Matrix& a);
/// K with KᵀK = positive_semidefinite_part(a).
Matrix positive_semidefinite_root(const Matrix& a);

}  // namespace tetraction
