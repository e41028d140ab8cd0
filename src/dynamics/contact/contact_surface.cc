#include "contact_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "tetraction/core/error.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

// The share of the area of a quadratic face that its corners have among bodies. It keeps them out of others; with a
// uniform pressure they should have none.
constexpr double kCornerShare = 1e-3;
// Guards of corners: the share of a quadratic face, which is a third of the triangle between the corner and the
// middles beside it, and of the thickness of the layer.
constexpr double kGuardArea = 1.0 / 12.0;
constexpr double kGuardReach = 0.5;

}  // namespace

ContactSurface contact_surface(const TetMesh& mesh, const Obstacle& obstacle, Corners corners) {
  const bool has_guards = corners == Corners::kGuarded && mesh.is_quadratic();
  std::set<Index> guarded;
  if (obstacle.surface.empty()) {
    throw InputError(fmt::format("No face of the body's boundary may touch the obstacle \"{}\".",
                                 obstacle.name));
  }
  const EdgeVertices middles(mesh);
  const Vector rest = mesh.rest_positions();
  std::map<Index, double> areas;
  for (const std::array<Index, 3>& face : obstacle.surface) {
    for (const Index v : face) {
      if (v >= 0 && v < mesh.vertex_count()) continue;
      throw InputError(
          fmt::format("The surface that touches the obstacle \"{}\" has vertex {}, which the mesh "
                      "does not have.",
                      obstacle.name, v));
    }
    const Vector3 a = vertex_block(rest, face[0]);
    const Vector3 b = vertex_block(rest, face[1]);
    const Vector3 c = vertex_block(rest, face[2]);
    const double third = (b - a).cross(c - a).norm() / 6.0;
    if (!mesh.is_quadratic()) {
      for (const Index v : face) areas[v] += third;
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const Index middle = middles.find(face.at(i), face.at((i + 1) % 3));
      if (has_guards) {
        areas[face.at(i)] += 3.0 * kGuardArea * third;
        areas[middle] += third;
        guarded.insert(face.at(i));
      } else {
        areas[face.at(i)] += kCornerShare * third;
        areas[middle] += (1.0 - kCornerShare) * third;
      }
    }
  }
  const std::vector<std::array<Index, 3>> triangles = middles.divide(obstacle.surface);
  ContactSurface surface;
  std::map<Index, Index> number;
  for (const auto& [v, area] : areas) {
    number[v] = static_cast<Index>(surface.vertices.size());
    surface.vertices.push_back(v);
    surface.areas.push_back(area);
    if (has_guards) surface.reaches.push_back(guarded.contains(v) ? kGuardReach : 1.0);
  }
  surface.rest.resize(3 * static_cast<Index>(surface.vertices.size()));
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    vertex_block(surface.rest, static_cast<Index>(i)) = vertex_block(rest, surface.vertices[i]);
  }
  std::set<std::array<Index, 2>> edges;
  for (const std::array<Index, 3>& triangle : triangles) {
    const std::array<Index, 3> own{number[triangle[0]], number[triangle[1]], number[triangle[2]]};
    surface.triangles.push_back(own);
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = own.at(i);
      const Index b = own.at((i + 1) % 3);
      edges.insert({std::min(a, b), std::max(a, b)});
    }
  }
  surface.edges.assign(edges.begin(), edges.end());
  return surface;
}

}  // namespace tetraction
