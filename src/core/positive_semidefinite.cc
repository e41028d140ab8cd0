#include "tetraction/core/positive_semidefinite.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace tetraction {
namespace {

// An eigendecomposition takes several times as long as a Cholesky factorisation, which succeeds for
// most matrices.
template <class Square>
Square project(const Square& a) {
  if (Eigen::LLT<Square>(a).info() == Eigen::Success) return a;
  const Eigen::SelfAdjointEigenSolver<Square> eigen(a);
  if (eigen.eigenvalues()[0] >= 0.0) return a;
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

Matrix3 positive_semidefinite_part(const Matrix3& a) {
  return project(a);
}

Matrix12 positive_semidefinite_part(const Matrix12& a) {
  return project(a);
}

Matrix12 positive_semidefinite_root(const Matrix12& a) {
  const Eigen::LLT<Matrix12> cholesky(a);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Matrix12> eigen(a);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace tetraction
