#include "point_location.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <optional>

#include "mesh/quadratic_shapes.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using Matrix32 = Eigen::Matrix<double, 3, 2>;

// A point on the boundary is outside by round-off. The limit of the barycentric coordinates is this.
constexpr double kOutside = -1e-9;
// Least barycentric coordinates that differ by less are equal.
constexpr double kEqualDepth = 1e-9;

// The nodes of an element at rest: four, or ten with those in the middles of the edges
// 01, 12, 02, 03, 13, 23.
std::vector<Vector3> nodes_of(const TetMesh& mesh, Index e) {
  const auto i = static_cast<std::size_t>(e);
  std::vector<Vector3> nodes;
  for (const Index v : mesh.tetrahedra[i]) {
    nodes.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
  }
  if (mesh.is_quadratic()) {
    for (const Index v : mesh.edge_vertices[i]) {
      nodes.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    }
  }
  return nodes;
}

// Six times the signed volume.
double triple(const Vector3& a, const Vector3& b, const Vector3& c) {
  return a.dot(b.cross(c));
}

std::array<double, 4> barycentric(const std::vector<Vector3>& x, const Vector3& point) {
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

// Barycentric coordinates of a point of an element with ten nodes: Newton's method for x(L) = point from
// the place l. Nothing if it does not converge, as far outside.
std::optional<std::array<double, 4>> newton_coordinates(const std::vector<Vector3>& x,
                                                        const Vector3& point,
                                                        std::array<double, 4> l) {
  constexpr int kIterations = 50;
  constexpr double kFar = 2.0;
  const double size = std::max({(x[1] - x[0]).norm(), (x[2] - x[0]).norm(), (x[3] - x[0]).norm()});
  for (double& own : l) own = std::clamp(own, -kFar, kFar);
  for (int i = 0; i < kIterations; ++i) {
    const auto n = quadratic_shapes(l);
    Vector3 rest = point;
    for (std::size_t a = 0; a < x.size(); ++a) rest -= n[a] * x[a];
    const Matrix3 edges = quadratic_edges(l, [&](int a) { return x[static_cast<std::size_t>(a)]; });
    const Vector3 change = edges.inverse() * rest;
    for (std::size_t k = 0; k < 3; ++k) {
      l[k + 1] += change[static_cast<Index>(k)];
      l[0] -= change[static_cast<Index>(k)];
    }
    const double largest = *std::max_element(l.begin(), l.end());
    if (!(largest < 2.0 * kFar)) return std::nullopt;
    if (rest.norm() <= 1e-14 * size) return l;
    if (change.cwiseAbs().maxCoeff() <= 1e-13) return l;
  }
  return std::nullopt;
}

// The same from the place in the tetrahedron of the corners, or, if that does not lead inside, from the
// centroid: strongly curved elements may have corners in a plane, or a tetrahedron of corners that is
// turned inside out.
std::optional<std::array<double, 4>> curved_coordinates(const std::vector<Vector3>& x,
                                                        const Vector3& point) {
  const auto depth = [](const std::optional<std::array<double, 4>>& l) {
    return l ? *std::min_element(l->begin(), l->end()) : -std::numeric_limits<double>::infinity();
  };
  auto found = newton_coordinates(x, point, barycentric(x, point));
  if (depth(found) >= kOutside) return found;
  auto other = newton_coordinates(x, point, {0.25, 0.25, 0.25, 0.25});
  return depth(other) > depth(found) ? other : found;
}

// Whether a point may be in an element, from the box of its nodes.
bool may_contain(const TetMesh& mesh, Index e, const Vector3& point) {
  const auto i = static_cast<std::size_t>(e);
  const auto node = [&](Index v) -> Vector3 { return mesh.vertices[static_cast<std::size_t>(v)]; };
  Vector3 low = node(mesh.tetrahedra[i][0]);
  Vector3 high = low;
  const auto add = [&](Index v) {
    low = low.cwiseMin(node(v));
    high = high.cwiseMax(node(v));
  };
  for (const Index v : mesh.tetrahedra[i]) add(v);
  if (mesh.is_quadratic()) {
    for (const Index v : mesh.edge_vertices[i]) add(v);
  }
  // A curved edge may leave the box of its nodes by an eighth of its length.
  const double room = (mesh.is_quadratic() ? 0.25 : 1e-6) * (high - low).maxCoeff();
  return ((point - low).array() >= -room).all() && ((high - point).array() >= -room).all();
}

// The nodes of each face: its corners and the middles of its edges.
constexpr std::array<std::array<std::size_t, 6>, 4> kFaces{
    {{0, 1, 2, 4, 5, 6}, {0, 1, 3, 4, 8, 7}, {0, 2, 3, 6, 9, 7}, {1, 2, 3, 5, 9, 8}}};

// Distance from the surface of an element, whose curved faces count as four triangles each.
double distance_to_element(const Vector3& point, const std::vector<Vector3>& x) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](std::size_t a, std::size_t b, std::size_t c) {
    least = std::min(least, distance_to_triangle(point, x[a], x[b], x[c]));
  };
  for (const auto& [a, b, c, ab, bc, ca] : kFaces) {
    if (x.size() == 4) {
      take(a, b, c);
      continue;
    }
    take(a, ab, ca);
    take(ab, b, bc);
    take(ca, bc, c);
    take(ab, bc, ca);
  }
  return least;
}

// Distance from the curved surface of an element with ten nodes. The parameters of a face are those of
// a grid of points, and from the nearest one Gauss–Newton steps lead to the foot of the normal.
double distance_to_curved_element(const Vector3& point, const std::vector<Vector3>& x) {
  constexpr int kGrid = 16;
  constexpr int kSteps = 30;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& nodes : kFaces) {
    // The point of the face, and its derivatives, at (r, s).
    const auto face = [&](double r, double s, Matrix32& tangents) -> Vector3 {
      const double l = 1.0 - r - s;
      const std::array<double, 6> n{l * (2.0 * l - 1.0), r * (2.0 * r - 1.0), s * (2.0 * s - 1.0),
                                    4.0 * l * r,         4.0 * r * s,         4.0 * s * l};
      const std::array<double, 6> by_r{1.0 - 4.0 * l, 4.0 * r - 1.0, 0.0,
                                       4.0 * (l - r), 4.0 * s,       -4.0 * s};
      const std::array<double, 6> by_s{1.0 - 4.0 * l, 0.0,     4.0 * s - 1.0,
                                       -4.0 * r,      4.0 * r, 4.0 * (l - s)};
      Vector3 at = Vector3::Zero();
      tangents.setZero();
      for (std::size_t a = 0; a < 6; ++a) {
        at += n[a] * x[nodes[a]];
        tangents.col(0) += by_r[a] * x[nodes[a]];
        tangents.col(1) += by_s[a] * x[nodes[a]];
      }
      return at;
    };
    Matrix32 tangents;
    Eigen::Vector2d best(0.0, 0.0);
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kGrid; ++i) {
      for (int j = 0; i + j <= kGrid; ++j) {
        const Eigen::Vector2d place(static_cast<double>(i) / kGrid, static_cast<double>(j) / kGrid);
        const double distance = (face(place[0], place[1], tangents) - point).norm();
        if (distance < nearest) {
          nearest = distance;
          best = place;
        }
      }
    }
    for (int step = 0; step < kSteps; ++step) {
      const Vector3 gap = point - face(best[0], best[1], tangents);
      const Eigen::Vector2d change =
          (tangents.transpose() * tangents).inverse() * (tangents.transpose() * gap);
      best += change;
      // Back into the triangle.
      best = best.cwiseMax(0.0);
      if (best.sum() > 1.0) best /= best.sum();
      if (!best.allFinite()) break;
      nearest = std::min(nearest, (face(best[0], best[1], tangents) - point).norm());
      if (change.cwiseAbs().maxCoeff() < 1e-13) break;
    }
    least = std::min(least, nearest);
  }
  return least;
}

[[noreturn]] void refuse_outside(const TetMesh& mesh, const Vector3& point) {
  double least = std::numeric_limits<double>::infinity();
  Index nearest = 0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const double distance = distance_to_element(point, nodes_of(mesh, e));
    if (distance < least) {
      least = distance;
      nearest = e;
    }
  }
  if (mesh.is_quadratic()) least = distance_to_curved_element(point, nodes_of(mesh, nearest));
  const MeshPart* part = mesh.part.get();
  const double least_of_all = least_of_parts(part, least);
  const double none = std::numeric_limits<double>::infinity();
  const auto id = static_cast<std::int64_t>(least_of_parts(
      part, least == least_of_all ? static_cast<double>(mesh.tetrahedron_id(nearest)) : none));
  throw InputError(fmt::format(
      "the point [{:.12g}, {:.12g}, {:.12g}] is outside the body, {:.6g} m from the nearest "
      "element, {}. Points are in the coordinates of the undeformed mesh (after mesh.scale and "
      "mesh.unit); `tetraction mesh info` shows its bounding box.",
      point.x(), point.y(), point.z(), least_of_all, id));
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
  const auto shapes = quadratic_shapes(weights);
  return {shapes.begin(), shapes.end()};
}

std::vector<PointInMesh> locate_all(const TetMesh& mesh, const Vector3& point) {
  if (!point.allFinite()) throw InputError("the point is not finite.");
  struct Candidate {
    double depth;
    PointInMesh place;
  };
  std::vector<Candidate> candidates;
  double deepest = -std::numeric_limits<double>::infinity();
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    if (!may_contain(mesh, e, point)) continue;
    const std::vector<Vector3> x = nodes_of(mesh, e);
    const auto weights =
        x.size() > 4 ? curved_coordinates(x, point) : std::optional(barycentric(x, point));
    if (!weights) continue;
    const double depth = *std::min_element(weights->begin(), weights->end());
    deepest = std::max(deepest, depth);
    candidates.push_back({depth, {e, *weights}});
  }
  deepest = largest_of_parts(mesh.part.get(), deepest);
  if (!(deepest >= kOutside)) refuse_outside(mesh, point);
  std::vector<PointInMesh> found;
  for (const Candidate& candidate : candidates) {
    if (candidate.depth >= deepest - kEqualDepth) found.push_back(candidate.place);
  }
  return found;
}

PointInMesh locate(const TetMesh& mesh, const Vector3& point) {
  PointInMesh found;
  for (const PointInMesh& place : locate_all(mesh, point)) {
    const Index e = place.tetrahedron;
    if (found.tetrahedron < 0 || mesh.tetrahedron_id(e) < mesh.tetrahedron_id(found.tetrahedron)) {
      found = place;
    }
  }
  const double id = found.tetrahedron >= 0
                        ? static_cast<double>(mesh.tetrahedron_id(found.tetrahedron))
                        : std::numeric_limits<double>::infinity();
  if (least_of_parts(mesh.part.get(), id) != id) found.tetrahedron = -1;
  return found;
}

}  // namespace tetraction
