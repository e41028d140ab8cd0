// The directions in which a vertex that is not free may move.
#pragma once

#include <Eigen/LU>

#include "tetraction/fem/free_coordinates.h"

namespace tetraction {

/// The projection P = Σ t tᵀ onto these directions t, which are orthonormal.
inline Matrix3 allowed_directions(const FreeCoordinates::VertexMap& map) {
  Matrix3 allowed = Matrix3::Zero();
  for (int i = 0; i < map.count; ++i) {
    allowed += map.columns.col(i) * map.columns.col(i).transpose();
  }
  return allowed;
}

/// P x.
inline Vector3 project(const FreeCoordinates::VertexMap& map, const Vector3& x) {
  Vector3 projected = Vector3::Zero();
  for (int i = 0; i < map.count; ++i) {
    projected += map.columns.col(i).dot(x) * map.columns.col(i);
  }
  return projected;
}

/// t (tᵀ B t)⁻¹ tᵀ for a symmetric matrix B. It is the inverse of P B P + c (1 − P) less (1 − P)/c. If tᵀ B t is
/// not positive definite, it is P/`substitute`.
inline Matrix3 inverse_along(const FreeCoordinates::VertexMap& map, const Matrix3& block,
                             double substitute) {
  const Matrix3 allowed = allowed_directions(map);
  const Matrix3 across = Matrix3::Identity() - allowed;
  const Matrix3 own = allowed * block * allowed;
  // There are one or two directions, so trace and determinant of tᵀ B t decide.
  const double scale = own.trace() / map.count;
  const Matrix3 filled = own + scale * across;
  if (!(scale > 0.0) || !(filled.determinant() > 0.0)) return allowed / substitute;
  return filled.inverse() - across / scale;
}

}  // namespace tetraction
