#include "picked_geometry.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "display_units.h"

namespace tetraction::viewer {
namespace {

constexpr double kDegree = 180.0 / std::numbers::pi;

struct SurfaceEdge {
  Index low, high;
  std::size_t triangle;
};

double angle_between(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * kDegree;
}

}  // namespace

std::vector<Index> face_vertices(const std::vector<std::array<Index, 3>>& triangles,
                                 const Vector& position, std::size_t start, double angle) {
  std::vector<SurfaceEdge> edges;
  std::vector<Vector3> normals;
  for (const auto& [a, b, c] : triangles) {
    const std::size_t triangle = normals.size();
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      edges.push_back({std::min(from, to), std::max(from, to), triangle});
    }
    const Vector3 origin = vertex_block(position, a);
    normals.push_back(
        (vertex_block(position, b) - origin).cross(vertex_block(position, c) - origin));
  }
  const auto ends = [](const SurfaceEdge& edge) { return std::pair{edge.low, edge.high}; };
  std::ranges::sort(edges, {}, ends);
  std::vector<bool> reached(triangles.size(), false);
  std::vector<std::size_t> waiting{start};
  std::vector<Index> vertices;
  reached[start] = true;
  while (!waiting.empty()) {
    const std::size_t triangle = waiting.back();
    waiting.pop_back();
    const auto& [a, b, c] = triangles[triangle];
    vertices.insert(vertices.end(), {a, b, c});
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      const auto shared = std::ranges::equal_range(
          edges, std::pair{std::min(from, to), std::max(from, to)}, {}, ends);
      for (const SurfaceEdge& edge : shared) {
        if (reached[edge.triangle]) continue;
        if (angle_between(normals[triangle], normals[edge.triangle]) >= angle) continue;
        reached[edge.triangle] = true;
        waiting.push_back(edge.triangle);
      }
    }
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

std::string measure(const Vector& position, const std::vector<Index>& vertices,
                    const std::vector<std::string>& names) {
  const auto at = [&](std::size_t i) { return Vector3(vertex_block(position, vertices[i])); };
  if (vertices.size() == 2) {
    return fmt::format("Distance of {} and {}: {}", names[0], names[1],
                       with_prefix((at(1) - at(0)).norm(), "m"));
  }
  if (vertices.size() != 3) return {};
  std::string text = "Angles";
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = angle_between(at((i + 1) % 3) - at(i), at((i + 2) % 3) - at(i));
    text += fmt::format("{} at {}: {:.2f}°", i == 0 ? "" : ",", names[i], angle);
  }
  return text;
}

}  // namespace tetraction::viewer
