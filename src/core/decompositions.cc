#include "decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace tetraction {

SymmetricEigen3 symmetric_eigen(const Matrix3& a) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen symmetric_eigen(const Matrix& a) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SingularVectors singular_vectors(const Matrix& a) {
  const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeFullU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.matrixV()};
}

}  // namespace tetraction
