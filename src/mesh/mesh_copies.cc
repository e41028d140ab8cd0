#include "tetraction/mesh/mesh_copies.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The numbers of all copies, from those of one.
void repeat_numbers(std::vector<std::int64_t>& numbers, std::size_t bodies) {
  if (numbers.empty()) return;
  const std::size_t count = numbers.size();
  const std::int64_t stride = *std::ranges::max_element(numbers) + 1;
  for (std::size_t i = count; i < bodies * count; ++i) {
    numbers.push_back(numbers[i - count] + stride);
  }
}

// Items of vertices or tetrahedra, which have numbers `stride` higher in each copy.
template <class Items, class Shifted>
void repeat_items(Items& items, std::size_t bodies, const Shifted& shifted) {
  const std::size_t count = items.size();
  items.reserve(bodies * count);
  for (std::size_t k = 1; k < bodies; ++k) {
    for (std::size_t i = 0; i < count; ++i)
      items.push_back(shifted(items[i], static_cast<Index>(k)));
  }
}

template <std::size_t N>
std::array<Index, N> plus(std::array<Index, N> numbers, Index shift) {
  for (Index& i : numbers) i += shift;
  return numbers;
}

}  // namespace

std::string group_of_copy(std::size_t k) {
  return fmt::format("body_{}", k);
}

TetMesh with_copies(TetMesh mesh, std::span<const MeshPlace> places) {
  if (places.empty()) return mesh;
  const std::size_t bodies = places.size() + 1;
  const Index vertices = mesh.vertex_count();
  const Index tetrahedra = mesh.tetrahedron_count();
  for (std::size_t k = 0; k < bodies; ++k) {
    const auto has_name = [&](const Group& group) { return group.name == group_of_copy(k); };
    if (std::ranges::any_of(mesh.groups, has_name)) {
      throw InputError(
          fmt::format("mesh.copies makes a group \"{}\", and {} has one of this name: "
                      "give it another name.",
                      group_of_copy(k), mesh.source));
    }
  }
  std::vector<Vector3> points(mesh.vertices.begin(), mesh.vertices.end());
  Vector3 lower = points.front();
  Vector3 upper = points.front();
  for (const Vector3& x : points) {
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  const Vector3 middle = 0.5 * (lower + upper);
  for (const MeshPlace& place : places) {
    const Vector3 turn = place.turn * (std::numbers::pi / 180.0);
    const double angle = turn.norm();
    const Matrix3 rotation = angle > 0.0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix()
                                         : Matrix3(Matrix3::Identity());
    for (Index v = 0; v < vertices; ++v) {
      const Vector3 x = points[static_cast<std::size_t>(v)];
      // Without a rotation the coordinates are moved and nothing else.
      points.push_back(angle > 0.0 ? Vector3(middle + rotation * (x - middle) + place.at)
                                   : Vector3(x + place.at));
    }
  }
  mesh.vertices.own() = std::move(points);

  std::vector<std::array<Index, 4>> corners(mesh.tetrahedra.begin(), mesh.tetrahedra.end());
  repeat_items(corners, bodies,
               [&](const auto& nodes, Index k) { return plus(nodes, k * vertices); });
  mesh.tetrahedra.own() = std::move(corners);
  repeat_items(mesh.edge_vertices, bodies,
               [&](const auto& nodes, Index k) { return plus(nodes, k * vertices); });
  repeat_numbers(mesh.vertex_ids, bodies);
  repeat_numbers(mesh.tetrahedron_ids, bodies);
  repeat_items(mesh.regions, bodies, [](int region, Index) { return region; });
  const std::int64_t next_id =
      mesh.vertex_ids.empty()
          ? vertices
          : *std::max_element(mesh.vertex_ids.begin(), mesh.vertex_ids.begin() + vertices) + 1;
  for (Group& group : mesh.groups) {
    const auto moved = [&](const auto& nodes, Index k) { return plus(nodes, k * vertices); };
    repeat_items(group.vertices, bodies, [&](Index v, Index k) { return v + k * vertices; });
    repeat_items(group.tetrahedra, bodies, [&](Index e, Index k) { return e + k * tetrahedra; });
    repeat_items(group.triangles, bodies, moved);
    repeat_items(group.lines, bodies, moved);
    repeat_items(group.detached_triangles, bodies, [&](std::array<std::int64_t, 3> ids, Index k) {
      for (std::int64_t& id : ids) id += k * next_id;
      return ids;
    });
    group.detached_lines *= static_cast<Index>(bodies);
  }
  for (std::size_t k = 0; k < bodies; ++k) {
    Group body;
    body.name = group_of_copy(k);
    body.vertices.resize(static_cast<std::size_t>(vertices));
    body.tetrahedra.resize(static_cast<std::size_t>(tetrahedra));
    std::iota(body.vertices.begin(), body.vertices.end(), static_cast<Index>(k) * vertices);
    std::iota(body.tetrahedra.begin(), body.tetrahedra.end(), static_cast<Index>(k) * tetrahedra);
    mesh.groups.push_back(std::move(body));
  }
  const auto repeat_columns = [bodies](std::map<std::string, Matrix>& arrays) {
    for (auto& [name, values] : arrays) {
      values = values.replicate(1, static_cast<Index>(bodies)).eval();
    }
  };
  repeat_columns(mesh.point_arrays);
  repeat_columns(mesh.cell_arrays);
  return mesh;
}

}  // namespace tetraction
