#include "tetraction/core/positive_semidefinite.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "decompositions.h"

namespace tetraction {
namespace {

// Matrices of linear elements, which are the most frequent, have a type of fixed size.
constexpr Index kUsualSize = 12;
using UsualMatrix = Eigen::Matrix<double, kUsualSize, kUsualSize>;

// Most matrices are positive definite. A Cholesky factorisation shows this in a fraction of the time of
// an eigendecomposition.
template <class M>
bool is_positive_definite(const M& a) {
  return Eigen::LLT<M>(a).info() == Eigen::Success;
}

template <class M>
Matrix root(const M& a) {
  const Eigen::LLT<M> cholesky(a);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const SymmetricEigen eigen = symmetric_eigen(Matrix(a));
  return eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose();
}

}  // namespace

Matrix3 positive_semidefinite_part(const Matrix3& a) {
  const SymmetricEigen3 eigen = symmetric_eigen(a);
  if (eigen.values[0] >= 0.0) return a;
  return eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
}

Eigen::Matrix<double, 6, 6> positive_semidefinite_part(const Eigen::Matrix<double, 6, 6>& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(a);
  if (eigen.eigenvalues()[0] >= 0.0) return a;
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

Matrix positive_semidefinite_part(const Matrix& a) {
  if (a.rows() == kUsualSize ? is_positive_definite(UsualMatrix(a)) : is_positive_definite(a)) {
    return a;
  }
  const SymmetricEigen eigen = symmetric_eigen(a);
  if (eigen.values[0] >= 0.0) return a;
  return eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
}

Matrix positive_semidefinite_root(const Matrix& a) {
  return a.rows() == kUsualSize ? root(UsualMatrix(a)) : root(a);
}

}  // namespace tetraction
