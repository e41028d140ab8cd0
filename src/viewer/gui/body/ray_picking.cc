#include "ray_picking.h"

#include <Eigen/Geometry>
#include <cmath>

namespace tetraction::viewer {

std::optional<RayHit> first_hit(const std::vector<std::array<Index, 3>>& triangles,
                                const Vector& position, const Vector3& origin,
                                const Vector3& direction,
                                const std::function<bool(const Vector3&)>& is_drawn) {
  // The method of Möller and Trumbore (1997), for both sides of a triangle.
  std::optional<RayHit> nearest;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3 a = vertex_block(position, triangles[t][0]);
    const Vector3 ab = vertex_block(position, triangles[t][1]) - a;
    const Vector3 ac = vertex_block(position, triangles[t][2]) - a;
    const Vector3 p = direction.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0.0) continue;
    const Vector3 s = origin - a;
    const double u = s.dot(p) / determinant;
    if (!(u >= 0.0 && u <= 1.0)) continue;
    const Vector3 q = s.cross(ab);
    const double v = direction.dot(q) / determinant;
    if (!(v >= 0.0 && u + v <= 1.0)) continue;
    const double distance = ac.dot(q) / determinant;
    if (!(distance > 0.0) || (nearest && distance >= nearest->distance)) continue;
    if (!is_drawn(origin + distance * direction)) continue;
    nearest = RayHit{t, distance};
  }
  return nearest;
}

}  // namespace tetraction::viewer
