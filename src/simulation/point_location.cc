#include "point_location.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A point on the boundary is outside by round-off. The limit of the barycentric coordinates is this.
constexpr double kOutside = -1e-9;

std::array<Vector3, 4> corners_of(const TetMesh& mesh, Index e) {
  std::array<Vector3, 4> corners;
  const auto tetrahedron = mesh.tetrahedra[static_cast<std::size_t>(e)];
  for (std::size_t a = 0; a < 4; ++a) {
    corners[a] = mesh.vertices[static_cast<std::size_t>(tetrahedron[a])];
  }
  return corners;
}

// Six times the signed volume.
double triple(const Vector3& a, const Vector3& b, const Vector3& c) {
  return a.dot(b.cross(c));
}

std::array<double, 4> barycentric(const std::array<Vector3, 4>& x, const Vector3& point) {
  const Vector3 r = point - x[0];
  const Vector3 e1 = x[1] - x[0];
  const Vector3 e2 = x[2] - x[0];
  const Vector3 e3 = x[3] - x[0];
  const double volume = triple(e1, e2, e3);
  const double w1 = triple(r, e2, e3) / volume;
  const double w2 = triple(e1, r, e3) / volume;
  const double w3 = triple(e1, e2, r) / volume;
  return {1.0 - w1 - w2 - w3, w1, w2, w3};
}

bool is_in_box(const std::array<Vector3, 4>& x, const Vector3& point) {
  const Vector3 low = x[0].cwiseMin(x[1]).cwiseMin(x[2]).cwiseMin(x[3]);
  const Vector3 high = x[0].cwiseMax(x[1]).cwiseMax(x[2]).cwiseMax(x[3]);
  const double room = 1e-6 * (high - low).maxCoeff();
  return ((point - low).array() >= -room).all() && ((high - point).array() >= -room).all();
}

[[noreturn]] void refuse_outside(const TetMesh& mesh, const Vector3& point) {
  double least = std::numeric_limits<double>::infinity();
  Index nearest = 0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const std::array<Vector3, 4> x = corners_of(mesh, e);
    const double distance = std::min({distance_to_triangle(point, x[0], x[1], x[2]),
                                      distance_to_triangle(point, x[0], x[1], x[3]),
                                      distance_to_triangle(point, x[0], x[2], x[3]),
                                      distance_to_triangle(point, x[1], x[2], x[3])});
    if (distance < least) {
      least = distance;
      nearest = e;
    }
  }
  throw InputError(fmt::format(
      "the point [{:.6g}, {:.6g}, {:.6g}] is outside the body, {:.6g} m from the nearest element, "
      "{}. Points are in the coordinates of the undeformed mesh (after mesh.scale and mesh.unit); "
      "`tetraction mesh info` shows its bounding box.",
      point.x(), point.y(), point.z(), least, mesh.tetrahedron_id(nearest)));
}

}  // namespace

double distance_to_triangle(const Vector3& point, const Vector3& a, const Vector3& b,
                            const Vector3& c) {
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  const Vector3 ap = point - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return ap.norm();
  const Vector3 bp = point - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return (ap - d1 / (d1 - d3) * ab).norm();
  const Vector3 cp = point - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return (ap - d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).norm();
  }
  const double sum = va + vb + vc;
  return (ap - vb / sum * ab - vc / sum * ac).norm();
}

std::vector<double> shape_functions(const std::array<double, 4>& weights, std::size_t nodes) {
  if (nodes == 4) return {weights.begin(), weights.end()};
  const auto& [a, b, c, d] = weights;
  return {a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), d * (2 * d - 1), 4 * a * b,
          4 * b * c,       4 * a * c,       4 * a * d,       4 * b * d,       4 * c * d};
}

PointInMesh locate(const TetMesh& mesh, const Vector3& point) {
  if (!point.allFinite()) throw InputError("the point is not finite.");
  PointInMesh found;
  double deepest = -std::numeric_limits<double>::infinity();
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const std::array<Vector3, 4> x = corners_of(mesh, e);
    if (!is_in_box(x, point)) continue;
    const std::array<double, 4> weights = barycentric(x, point);
    const double depth = *std::min_element(weights.begin(), weights.end());
    if (depth <= deepest) continue;
    deepest = depth;
    found = {e, weights};
  }
  if (!(deepest >= kOutside)) refuse_outside(mesh, point);
  return found;
}

}  // namespace tetraction
