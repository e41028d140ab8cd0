#include "triangle_mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A triangle whose height is below this part of its longest edge has no normal.
constexpr double kFlatTriangle = 1e-10;
// An edge is flat up to this sine of the angle between its triangles: far below the distances that a contact
// layer allows in proportion to the size of triangles.
constexpr double kFlatEdge = 1e-5;

std::size_t point_at(Index i) {
  return static_cast<std::size_t>(i);
}

bool earlier_point(const Vector3& a, const Vector3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

// From which point of the input each distinct point is.
std::vector<Index> equal_points(const std::vector<Vector3>& points) {
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index i, Index j) {
    const Vector3& a = points[point_at(i)];
    const Vector3& b = points[point_at(j)];
    if (earlier_point(a, b)) return true;
    return !earlier_point(b, a) && i < j;
  });
  std::vector<Index> first(points.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool repeated = k > 0 && points[point_at(order[k])] == points[point_at(order[k - 1])];
    first[point_at(order[k])] = repeated ? first[point_at(order[k - 1])] : order[k];
  }
  return first;
}

// Where a plane at the signed distance `start`, in lengths of its direction, is crossed.
void add_plane(const Vector3& direction, double start, const Vector3& move,
               std::vector<TriangleMesh::Crossing>& crossings) {
  const double end = start + direction.dot(move);
  if ((start < 0.0) == (end < 0.0)) return;
  const double t = start / (start - end);
  if (t > 0.0 && t < 1.0) crossings.push_back({t, (t / (start - end)) * direction});
}

}  // namespace

TriangleMesh::TriangleMesh(const std::vector<Vector3>& points,
                           const std::vector<std::array<Index, 3>>& triangles) {
  if (triangles.empty()) throw InputError("The mesh of an obstacle has no triangle.");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw InputError(
          fmt::format("Point {} of the mesh of an obstacle (counted from 0) is not finite.", i));
    }
  }
  weld(points, triangles);
  find_edges();
  build_trees();
}

void TriangleMesh::weld(const std::vector<Vector3>& points,
                        const std::vector<std::array<Index, 3>>& triangles) {
  const std::vector<Index> first = equal_points(points);
  std::vector<Index> number(points.size(), -1);
  std::vector<std::pair<std::array<Index, 3>, std::size_t>> corners;
  corners.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    std::array<Index, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index i = triangles[t][k];
      if (i < 0 || i >= static_cast<Index>(points.size())) {
        throw InputError(
            fmt::format("Triangle {} of the mesh of an obstacle (counted from 0) has the corner "
                        "{}, but there are {} points.",
                        t, i, points.size()));
      }
      corner[k] = first[point_at(i)];
    }
    const Vector3& a = points[point_at(corner[0])];
    const Vector3 u = points[point_at(corner[1])] - a;
    const Vector3 v = points[point_at(corner[2])] - a;
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
    // Scaled, so that the squares of the products of very small edges are no zeros.
    const double scale = longest > 0.0 ? 1.0 / std::sqrt(longest) : 0.0;
    const double area = (scale * u).cross(scale * v).norm();
    if (!(area > kFlatTriangle)) {
      throw InputError(
          fmt::format("Triangle {} of the mesh of an obstacle (counted from 0) has no area: its "
                      "corners ({}, {}, {}), "
                      "({}, {}, {}) and ({}, {}, {}) lie on a line. Remove it, and mesh the "
                      "surface there anew.",
                      t, a[0], a[1], a[2], a[0] + u[0], a[1] + u[1], a[2] + u[2], a[0] + v[0],
                      a[1] + v[1], a[2] + v[2]));
    }
    std::array<Index, 3> sorted = corner;
    std::sort(sorted.begin(), sorted.end());
    corners.emplace_back(sorted, t);
  }
  std::sort(corners.begin(), corners.end());
  std::vector<bool> kept(triangles.size(), true);
  for (std::size_t k = 1; k < corners.size(); ++k) {
    if (corners[k].first == corners[k - 1].first) kept[corners[k].second] = false;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!kept[t]) continue;
    std::array<Index, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index i = first[point_at(triangles[t][k])];
      if (number[point_at(i)] < 0) {
        number[point_at(i)] = static_cast<Index>(points_.size());
        // Adding zero makes 0 of −0.
        points_.push_back(points[point_at(i)].array() + 0.0);
      }
      triangle[k] = number[point_at(i)];
    }
    triangles_.push_back(triangle);
    const Vector3& a = points_[point_at(triangle[0])];
    Vector3 u = points_[point_at(triangle[1])] - a;
    Vector3 v = points_[point_at(triangle[2])] - a;
    normals_.push_back(u.normalized().cross(v.normalized()).normalized());
  }
}

void TriangleMesh::find_edges() {
  std::vector<std::pair<std::array<Index, 2>, std::array<Index, 2>>> sides;
  sides.reserve(3 * triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index i = triangles_[t][k];
      const Index j = triangles_[t][(k + 1) % 3];
      sides.push_back(
          {{std::min(i, j), std::max(i, j)}, {static_cast<Index>(t), static_cast<Index>(k)}});
    }
  }
  std::sort(sides.begin(), sides.end());
  triangle_edges_.resize(triangles_.size());
  std::vector<std::vector<Index>> triangles_of_edge;
  watertight_ = true;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    if (k == 0 || sides[k].first != sides[k - 1].first) {
      edges_.push_back(sides[k].first);
      triangles_of_edge.emplace_back();
    }
    const auto [triangle, side] = sides[k].second;
    triangle_edges_[point_at(triangle)][point_at(side)] = static_cast<Index>(edges_.size()) - 1;
    triangles_of_edge.back().push_back(triangle);
  }
  coefficients_.assign(point_at(feature_count()), 1.0);
  const std::size_t vertices = point_at(first_vertex());
  for (const auto& triangle : triangles_) {
    for (const Index i : triangle) coefficients_[vertices + point_at(i)] -= 1.0;
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const std::size_t count = triangles_of_edge[e].size();
    watertight_ = watertight_ && count % 2 == 0;
    const double own = 1.0 - static_cast<double>(count);
    coefficients_[point_at(first_edge()) + e] = own;
    for (const Index i : edges_[e]) coefficients_[vertices + point_at(i)] -= own;
  }
  find_sharp_features(triangles_of_edge);
}

void TriangleMesh::find_sharp_features(const std::vector<std::vector<Index>>& triangles_of_edge) {
  std::vector<bool> sharp(points_.size(), false);
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const auto& triangles = triangles_of_edge[e];
    bool flat = triangles.size() == 2;
    if (flat) {
      const Vector3& a = normals_[point_at(triangles[0])];
      const Vector3& b = normals_[point_at(triangles[1])];
      flat = a.cross(b).norm() <= kFlatEdge;
      // Two triangles that lie on each other, as at the edge of a folded sheet, are not flat.
      const auto corner = [&](std::size_t t) {
        for (const Index i : triangles_[point_at(triangles[t])]) {
          if (i != edges_[e][0] && i != edges_[e][1]) return points_[point_at(i)];
        }
        return points_[point_at(edges_[e][0])];
      };
      const Vector3 along =
          (points_[point_at(edges_[e][1])] - points_[point_at(edges_[e][0])]).normalized();
      const Vector3& origin = points_[point_at(edges_[e][0])];
      const auto across = [&](std::size_t t) {
        const Vector3 r = corner(t) - origin;
        return Vector3(r - along.dot(r) * along);
      };
      flat = flat && across(0).dot(across(1)) < 0.0;
    }
    if (flat) continue;
    sharp_edges_.push_back(static_cast<Index>(e));
    for (const Index i : edges_[e]) sharp[point_at(i)] = true;
  }
  for (std::size_t i = 0; i < sharp.size(); ++i) {
    if (sharp[i]) sharp_vertices_.push_back(static_cast<Index>(i));
  }
}

void TriangleMesh::build_trees() {
  std::vector<Box> boxes(triangles_.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const Index i : triangles_[t]) boxes[t].add(points_[point_at(i)]);
  }
  triangle_tree_ = BoxTree(boxes);
  const auto edge_box = [&](Index e) {
    Box box;
    for (const Index i : edges_[point_at(e)]) box.add(points_[point_at(i)]);
    return box;
  };
  const auto vertex_box = [&](Index i) { return Box{points_[point_at(i)], points_[point_at(i)]}; };
  boxes.clear();
  for (std::size_t e = 0; e < edges_.size(); ++e) boxes.push_back(edge_box(static_cast<Index>(e)));
  edge_tree_ = BoxTree(boxes);
  boxes.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    boxes.push_back(vertex_box(static_cast<Index>(i)));
  }
  vertex_tree_ = BoxTree(boxes);
  boxes.clear();
  for (const Index e : sharp_edges_) boxes.push_back(edge_box(e));
  sharp_edge_tree_ = BoxTree(boxes);
  boxes.clear();
  for (const Index i : sharp_vertices_) boxes.push_back(vertex_box(i));
  sharp_vertex_tree_ = BoxTree(boxes);
}

Index TriangleMesh::closest_feature_of_edge(Index edge, const Vector3& x) const {
  const auto& [i, j] = edges_[point_at(edge)];
  const Vector3 along = points_[point_at(j)] - points_[point_at(i)];
  const double t = along.dot(x - points_[point_at(i)]);
  if (t <= 0.0) return first_vertex() + i;
  if (t >= along.squaredNorm()) return first_vertex() + j;
  return first_edge() + edge;
}

Index TriangleMesh::closest_feature_of_triangle(Index triangle, const Vector3& x) const {
  const auto& corners = triangles_[point_at(triangle)];
  const Vector3& normal = normals_[point_at(triangle)];
  bool inside = true;
  for (std::size_t k = 0; k < 3 && inside; ++k) {
    const Vector3& a = points_[point_at(corners[k])];
    const Vector3& b = points_[point_at(corners[(k + 1) % 3])];
    inside = normal.cross(b - a).dot(x - a) > 0.0;
  }
  if (inside) return triangle;
  Index best = -1;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Index edge : triangle_edges_[point_at(triangle)]) {
    const Index feature = closest_feature_of_edge(edge, x);
    const double squared = offset(feature, x).squaredNorm();
    if (best < 0 || squared < smallest) {
      best = feature;
      smallest = squared;
    }
  }
  return best;
}

Vector3 TriangleMesh::offset(Index feature, const Vector3& x) const {
  if (feature < first_edge()) {
    const Vector3& normal = normals_[point_at(feature)];
    return normal.dot(x - points_[point_at(triangles_[point_at(feature)][0])]) * normal;
  }
  if (feature >= first_vertex()) return x - points_[point_at(feature - first_vertex())];
  const auto& [i, j] = edges_[point_at(feature - first_edge())];
  const Vector3 along = points_[point_at(j)] - points_[point_at(i)];
  const double length = along.squaredNorm();
  const Vector3 r = x - points_[point_at(i)];
  const double t = r.dot(along) / length;
  // From the nearer end, so that an error of t does not matter.
  return t < 0.5 ? Vector3(r - t * along) : Vector3(x - points_[point_at(j)] + (1.0 - t) * along);
}

Matrix3 TriangleMesh::projector(Index feature) const {
  if (feature < first_edge()) {
    return normals_[point_at(feature)] * normals_[point_at(feature)].transpose();
  }
  if (feature >= first_vertex()) return Matrix3::Identity();
  const auto& [i, j] = edges_[point_at(feature - first_edge())];
  const Vector3 along = (points_[point_at(j)] - points_[point_at(i)]).normalized();
  return Matrix3::Identity() - along * along.transpose();
}

void TriangleMesh::add_crossings(Index triangle, const Vector3& x, const Vector3& move,
                                 std::vector<Crossing>& crossings) const {
  // The planes that bound the places to which one feature is closest.
  const std::size_t before = crossings.size();
  const auto& corners = triangles_[point_at(triangle)];
  for (std::size_t k = 0; k < 3; ++k) {
    const Index i = corners[k];
    const Index j = corners[(k + 1) % 3];
    const Vector3& a = points_[point_at(std::min(i, j))];
    const Vector3& b = points_[point_at(std::max(i, j))];
    const Vector3 along = b - a;
    const Vector3 side = normals_[point_at(triangle)].cross(along);
    add_plane(side, side.dot(x - a), move, crossings);
    add_plane(along, along.dot(x - a), move, crossings);
    add_plane(along, along.dot(x - b), move, crossings);
  }
  if (crossings.size() == before) return;
  // Only those at which the closest feature does change.
  const auto own = crossings.begin() + static_cast<std::ptrdiff_t>(before);
  std::sort(own, crossings.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  const auto feature_between = [&](double a, double b) {
    return closest_feature_of_triangle(triangle, x + 0.5 * (a + b) * move);
  };
  std::size_t kept = before;
  Index feature = feature_between(0.0, crossings[before].t);
  for (std::size_t k = before; k < crossings.size(); ++k) {
    const double next = k + 1 < crossings.size() ? crossings[k + 1].t : 1.0;
    if (next == crossings[k].t) continue;
    const Index after = feature_between(crossings[k].t, next);
    if (after != feature) crossings[kept++] = crossings[k];
    feature = after;
  }
  crossings.resize(kept);
}

void TriangleMesh::add_edge_crossings(Index edge, const Vector3& x, const Vector3& move,
                                      std::vector<Crossing>& crossings) const {
  const auto& [i, j] = edges_[point_at(edge)];
  const Vector3& a = points_[point_at(i)];
  const Vector3& b = points_[point_at(j)];
  const Vector3 along = b - a;
  add_plane(along, along.dot(x - a), move, crossings);
  add_plane(along, along.dot(x - b), move, crossings);
}

}  // namespace tetraction
