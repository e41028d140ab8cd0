// The rotation of a moving triangle, for friction between sides that both move.
#pragma once

#include <Eigen/Geometry>
#include <array>

#include "tetraction/core/types.h"

namespace tetraction {

/// The matrices W_k of a triangle x_k with ω = Σ W_k v_k: the angular velocity of its plane, and, about its normal n, half
/// of the curl of the velocities in the plane,
///
///     W_k = −(n × g_k) nᵀ + ½ n (n × g_k)ᵀ,
///
/// with the gradients g_k of the three linear functions that are 1 at x_k and 0 at the other corners, 1/m. Velocities
/// v_k = ω × x_k + c of a rigid motion have this ω exactly. The triangle must have an area.
inline std::array<Matrix3, 3> face_rotation(const std::array<Vector3, 3>& x) {
  const Vector3 area = (x[1] - x[0]).cross(x[2] - x[0]);
  const double twice = area.norm();
  const Vector3 n = area / twice;
  std::array<Matrix3, 3> w;
  for (std::size_t k = 0; k < 3; ++k) {
    // g_k = n × (opposite edge)/(2A), and n × g_k = −(opposite edge)/(2A).
    const Vector3 turned = -(x[(k + 2) % 3] - x[(k + 1) % 3]) / twice;
    w[k] = -turned * n.transpose() + 0.5 * n * turned.transpose();
  }
  return w;
}

/// [a]×: the matrix with [a]× b = a × b.
inline Matrix3 cross_matrix(const Vector3& a) {
  Matrix3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

}  // namespace tetraction
