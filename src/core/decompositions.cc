#include "decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Jacobi>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace tetraction {

SymmetricEigen3 symmetric_eigen(const Matrix3& a) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen symmetric_eigen(const Matrix& a) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen jacobi_eigen(Matrix a) {
  constexpr int kSweeps = 50;
  const Index n = a.rows();
  Matrix vectors = Matrix::Identity(n, n);
  bool turned = true;
  for (int sweep = 0; sweep < kSweeps && turned; ++sweep) {
    turned = false;
    for (Index p = 0; p < n; ++p) {
      for (Index q = p + 1; q < n; ++q) {
        // The criterion is relative to the two entries, not to the matrix.
        const double scale = std::sqrt(std::abs(a(p, p))) * std::sqrt(std::abs(a(q, q)));
        if (std::abs(a(p, q)) <= std::numeric_limits<double>::epsilon() * scale) continue;
        Eigen::JacobiRotation<double> rotation;
        if (!rotation.makeJacobi(a, p, q)) continue;
        a.applyOnTheLeft(p, q, rotation.adjoint());
        a.applyOnTheRight(p, q, rotation);
        a(p, q) = a(q, p) = 0.0;
        vectors.applyOnTheRight(p, q, rotation);
        turned = true;
      }
    }
  }
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return a(i, i) < a(j, j); });
  SymmetricEigen eigen{Vector(n), Matrix(n, n)};
  for (Index i = 0; i < n; ++i) {
    const Index from = order[static_cast<std::size_t>(i)];
    eigen.values[i] = a(from, from);
    eigen.vectors.col(i) = vectors.col(from);
  }
  return eigen;
}

SingularVectors singular_vectors(const Matrix& a) {
  const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeFullU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.matrixV()};
}

Matrix3 proper_rotation(const Matrix3& a) {
  const Eigen::JacobiSVD<Matrix3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 signs = Vector3::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace tetraction
