// Decompositions of dense matrices.
#include "core/decompositions.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/pseudo_random.h"

namespace tetraction {
namespace {

// D A D with a well-conditioned A: the eigenvalues range over 24 orders of magnitude, and those of the
// inverse are their inverses to many digits.
TEST(JacobiEigen, SmallEigenvaluesHaveTheirOwnDigits) {
  constexpr Index kSize = 7;
  const Matrix random = pseudo_random(kSize * kSize).reshaped(kSize, kSize);
  const Matrix a = Matrix::Identity(kSize, kSize) + 0.02 * (random + random.transpose());
  Vector d(kSize);
  for (Index i = 0; i < kSize; ++i) d[i] = std::pow(10.0, 2.0 * static_cast<double>(i));
  const SymmetricEigen eigen = jacobi_eigen(d.asDiagonal() * a * d.asDiagonal());
  const Vector inverse_d = d.cwiseInverse();
  const Matrix inverse = inverse_d.asDiagonal() * a.inverse() * inverse_d.asDiagonal();
  const SymmetricEigen other = jacobi_eigen(inverse);
  for (Index i = 0; i < kSize; ++i) {
    EXPECT_NEAR(eigen.values[i] * other.values[kSize - 1 - i], 1.0, 1e-12) << i;
  }
  EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Matrix::Identity(kSize, kSize)).norm(),
            1e-13);
}

TEST(JacobiEigen, AgreesWithTheOtherMethod) {
  constexpr Index kSize = 12;
  const Matrix random = pseudo_random(kSize * kSize).reshaped(kSize, kSize);
  const Matrix a = random + random.transpose();
  const SymmetricEigen eigen = jacobi_eigen(a);
  EXPECT_LT((eigen.values - symmetric_eigen(a).values).norm(), 1e-13 * a.norm());
  EXPECT_LT((a * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(),
            1e-13 * a.norm());
}

}  // namespace
}  // namespace tetraction
