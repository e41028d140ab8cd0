// Edges that cross triangles.
#pragma once

#include <Eigen/Geometry>

#include "tetraction/core/types.h"

namespace tetraction {

/// Whether the edge from a to b crosses the triangle p, q, r from one side to the other, its border included.
inline bool edge_crosses_triangle(const Vector3& a, const Vector3& b, const Vector3& p,
                                  const Vector3& q, const Vector3& r) {
  const Vector3 normal = (q - p).cross(r - p);
  const double from = normal.dot(a - p);
  const double to = normal.dot(b - p);
  if (!((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0))) return false;
  const Vector3 along = b - a;
  const double u = along.dot((p - a).cross(q - a));
  const double v = along.dot((q - a).cross(r - a));
  const double w = along.dot((r - a).cross(p - a));
  return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
}

}  // namespace tetraction
