// Invariants of the strain, free of cancellation near the rest state.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "tetraction/core/types.h"

namespace tetraction {

/// E = ½(FᵀF − I), computed without cancellation as sym H + ½ HᵀH with the displacement gradient
/// H = F − I.
inline Matrix3 green_strain(const Matrix3& f) {
  const Matrix3 h = f - Matrix3::Identity();
  return 0.5 * (h + h.transpose() + h.transpose() * h);
}

/// x − ln(1 + x) for x > −1, accurate near 0.
inline double x_minus_log1p(double x) {
  if (std::abs(x) > 0.01) return x - std::log1p(x);
  // Ten terms of the series x²/2 − x³/3 + x⁴/4 − …; the relative error at |x| = 0.01 is below 1e-21.
  double sum = 0.0;
  for (int k = 11; k >= 2; --k) sum = ((k % 2 == 0) ? 1.0 : -1.0) / k + x * sum;
  return x * x * sum;
}

/// With A = C − I = 2E and its invariants II = ½(tr²A − tr A²), III = det A, we have
/// J² = 1 + a with a = tr A + II + III, I₁ − 3 = tr A and I₂ − 3 = 2 tr A + II. The differences
/// that occur in the energies are of second order in the strain. The formulas below do not contain
/// the terms of first order, which would cancel and cost digits:
///
///     I₁ − 3 − 2 ln J = a − ln(1 + a) − II − III
///     I₂ − 3 − 4 ln J = 2 (a − ln(1 + a)) − II − 2 III
struct StrainInvariants {
  double i1_term = 0.0;        ///< I₁ − 3 − 2 ln J
  double i2_term = 0.0;        ///< I₂ − 3 − 4 ln J
  double log_j = 0.0;          ///< ln J
  double trace = 0.0;          ///< I₁ − 3
  double volume_change = 0.0;  ///< J − 1

  explicit StrainInvariants(const Matrix3& f) {
    const Matrix3 a_matrix = 2.0 * green_strain(f);
    trace = a_matrix.trace();
    const double second = 0.5 * (trace * trace - a_matrix.squaredNorm());
    const double third = a_matrix.determinant();
    const double a = trace + second + third;
    if (std::abs(a) < 0.5 && trace < 1.0) {
      const double difference = x_minus_log1p(a);
      log_j = 0.5 * std::log1p(a);
      volume_change = a / (1.0 + std::sqrt(1.0 + a));
      i1_term = difference - second - third;
      i2_term = 2.0 * difference - second - 2.0 * third;
    } else {
      // Far from rest the plain formulas do not cancel, and det F is more accurate than 1 + a.
      const double j = f.determinant();
      log_j = std::log(j);
      volume_change = j - 1.0;
      i1_term = trace - 2.0 * log_j;
      // I₂ = |cof F|² is a sum of squares and keeps its digits. The formula ½(I₁² − tr C²) would
      // cancel for large stretches.
      const double i2 = f.col(1).cross(f.col(2)).squaredNorm() +
                        f.col(2).cross(f.col(0)).squaredNorm() +
                        f.col(0).cross(f.col(1)).squaredNorm();
      i2_term = i2 - 3.0 - 4.0 * log_j;
    }
  }
};

}  // namespace tetraction
