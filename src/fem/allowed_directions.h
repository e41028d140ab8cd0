// The directions in which a vertex that is not free may move.
#pragma once

#include "tetraction/fem/free_coordinates.h"

namespace tetraction {

/// The projection Σ t tᵀ onto these directions t, which are orthonormal.
inline Matrix3 allowed_directions(const FreeCoordinates::VertexMap& map) {
  Matrix3 allowed = Matrix3::Zero();
  for (int i = 0; i < map.count; ++i) {
    allowed += map.columns.col(i) * map.columns.col(i).transpose();
  }
  return allowed;
}

}  // namespace tetraction
