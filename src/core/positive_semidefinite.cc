#include "tetraction/core/positive_semidefinite.h"

#include <Eigen/Cholesky>

#include "decompositions.h"

namespace tetraction {
namespace {

// Most matrices are positive definite. A Cholesky factorisation shows this in a fraction of the time of
// an eigendecomposition.
bool is_positive_definite(const Matrix12& a) {
  return Eigen::LLT<Matrix12>(a).info() == Eigen::Success;
}

}  // namespace

Matrix3 positive_semidefinite_part(const Matrix3& a) {
  const SymmetricEigen3 eigen = symmetric_eigen(a);
  if (eigen.values[0] >= 0.0) return a;
  return eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
}

Matrix12 positive_semidefinite_part(const Matrix12& a) {
  if (is_positive_definite(a)) return a;
  const SymmetricEigen eigen = symmetric_eigen(Matrix(a));
  if (eigen.values[0] >= 0.0) return a;
  return eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
}

Matrix12 positive_semidefinite_root(const Matrix12& a) {
  const Eigen::LLT<Matrix12> cholesky(a);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const SymmetricEigen eigen = symmetric_eigen(Matrix(a));
  return eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose();
}

}  // namespace tetraction
