// The generalised minimal residual method for matrices that need not be symmetric.
#pragma once

#include <Eigen/Jacobi>
#include <cmath>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// How a solve by GMRES ended.
struct GmresReport {
  int iterations = 0;
  double reduction = 1.0;  ///< |b − A x| at the end over |b|
  bool converged = false;
};

/// Solves A x = b until |b − A x| ≤ forcing × |b|, in at most `max_iterations` iterations from x = 0
/// (Saad & Schultz 1986). multiply(v, w) computes w = A v and precondition(v, w) computes w = M⁻¹ v. The
/// preconditioner is applied on the right, so that the residual is that of the original system. Every
/// iteration stores one vector, so that `max_iterations` bounds the memory.
///
/// If `kFlexible` is true, the preconditioner need not be linear nor the same in each iteration, as if it
/// is an iterative method itself (Saad 1993). An iteration then stores two vectors.
template <bool kFlexible = false, class Multiply, class Precondition>
GmresReport gmres(const Vector& b, const Multiply& multiply, const Precondition& precondition,
                  double forcing, int max_iterations, Vector& x) {
  GmresReport report;
  x.setZero(b.size());
  const double scale = b.norm();
  if (scale == 0.0 || !std::isfinite(scale)) {
    report.reduction = 0.0;
    report.converged = scale == 0.0;
    return report;
  }
  std::vector<Vector> basis{b / scale};
  std::vector<Eigen::JacobiRotation<double>> rotations;
  Matrix triangle = Matrix::Zero(max_iterations + 1, max_iterations);
  Vector right = Vector::Zero(max_iterations + 1);  // right-hand side of the least-squares problem
  right[0] = scale;
  Vector preconditioned;
  std::vector<Vector> all_preconditioned;
  Vector next;
  int k = 0;
  while (k < max_iterations && !report.converged) {
    precondition(basis.back(), preconditioned);
    if constexpr (kFlexible) all_preconditioned.push_back(preconditioned);
    multiply(preconditioned, next);
    for (int i = 0; i <= k; ++i) {
      triangle(i, k) = basis[static_cast<std::size_t>(i)].dot(next);
      next -= triangle(i, k) * basis[static_cast<std::size_t>(i)];
    }
    const double length = next.norm();
    if (!std::isfinite(length)) break;
    for (int i = 0; i < k; ++i) {
      triangle.col(k).applyOnTheLeft(i, i + 1, rotations[static_cast<std::size_t>(i)].adjoint());
    }
    triangle(k + 1, k) = length;
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(triangle(k, k), length);
    rotations.push_back(rotation);
    triangle.col(k).applyOnTheLeft(k, k + 1, rotation.adjoint());
    right.applyOnTheLeft(k, k + 1, rotation.adjoint());
    ++k;
    report.reduction = std::abs(right[k]) / scale;
    report.converged = report.reduction <= forcing;
    // The Krylov space does not grow any further. Its solution is exact unless A is singular.
    if (length <= 1e-14 * scale) break;
    basis.push_back(next / length);
  }
  report.iterations = k;
  if (k == 0) return report;
  const Vector weights =
      triangle.topLeftCorner(k, k).template triangularView<Eigen::Upper>().solve(right.head(k));
  if constexpr (kFlexible) {
    for (int i = 0; i < k; ++i) x += weights[i] * all_preconditioned[static_cast<std::size_t>(i)];
    return report;
  }
  Vector sum = Vector::Zero(b.size());
  for (int i = 0; i < k; ++i) sum += weights[i] * basis[static_cast<std::size_t>(i)];
  precondition(sum, x);
  return report;
}

}  // namespace tetraction
