// The vertices in the middles of the edges of quadratic tetrahedra.
#include <algorithm>
#include <utility>

#include "group_middles.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

void sort_unique(std::vector<Index>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

void add_middles(const TetMesh& mesh, const EdgeVertices& edges, Group& group) {
  const auto add = [&](Index a, Index b) {
    if (const Index middle = edges.find(a, b); middle >= 0) group.vertices.push_back(middle);
  };
  if (group.dimension == 3) {
    for (const Index e : group.tetrahedra) {
      for (const Index v : mesh.edge_vertices[static_cast<std::size_t>(e)]) {
        group.vertices.push_back(v);
      }
    }
  } else if (group.dimension == 2) {
    for (const auto& [a, b, c] : group.triangles) {
      add(a, b);
      add(b, c);
      add(c, a);
    }
  } else if (group.dimension == 1) {
    for (const auto& [a, b] : group.lines) add(a, b);
  }
  sort_unique(group.vertices);
}

EdgeVertices::EdgeVertices(const TetMesh& mesh) {
  for (std::size_t e = 0; e < mesh.edge_vertices.size(); ++e) {
    const auto t = mesh.tetrahedra[e];
    for (std::size_t k = 0; k < kTetrahedronEdges.size(); ++k) {
      add(t[kTetrahedronEdges[k][0]], t[kTetrahedronEdges[k][1]], mesh.edge_vertices[e][k]);
    }
  }
}

std::vector<Index> EdgeVertices::of_face(const std::array<Index, 3>& face) const {
  std::vector<Index> vertices(face.begin(), face.end());
  for (std::size_t k = 0; k < 3 && !empty(); ++k) {
    if (const Index middle = find(face[k], face[(k + 1) % 3]); middle >= 0) {
      vertices.push_back(middle);
    }
  }
  return vertices;
}

std::vector<std::array<Index, 3>> EdgeVertices::divide(
    const std::vector<std::array<Index, 3>>& faces) const {
  if (empty()) return faces;
  std::vector<std::array<Index, 3>> triangles;
  for (const auto& face : faces) {
    const std::vector<Index> v = of_face(face);
    if (v.size() < 6) {
      triangles.push_back(face);
      continue;
    }
    triangles.push_back({v[0], v[3], v[5]});
    triangles.push_back({v[3], v[1], v[4]});
    triangles.push_back({v[5], v[4], v[2]});
    triangles.push_back({v[3], v[4], v[5]});
  }
  return triangles;
}

TetMesh with_edge_vertices(TetMesh mesh) {
  if (mesh.is_quadratic()) return mesh;
  const Index corners = mesh.vertex_count();
  EdgeVertices edges;
  std::vector<std::pair<Index, Index>> ends;  // of the edges, by their new vertices
  mesh.edge_vertices.reserve(mesh.tetrahedra.size());
  for (const auto t : mesh.tetrahedra) {
    auto& middles = mesh.edge_vertices.emplace_back();
    for (std::size_t k = 0; k < middles.size(); ++k) {
      const Index a = t[kTetrahedronEdges[k][0]];
      const Index b = t[kTetrahedronEdges[k][1]];
      const auto next = corners + static_cast<Index>(ends.size());
      middles[k] = edges.add(a, b, next);
      if (middles[k] == next) ends.emplace_back(a, b);
    }
  }
  std::vector<Vector3>& vertices = mesh.vertices.own();
  vertices.reserve(vertices.size() + ends.size());
  for (const auto& [a, b] : ends) {
    vertices.push_back(
        0.5 * (vertices[static_cast<std::size_t>(a)] + vertices[static_cast<std::size_t>(b)]));
  }
  if (!mesh.vertex_ids.empty()) {
    std::int64_t id = *std::max_element(mesh.vertex_ids.begin(), mesh.vertex_ids.end());
    for (std::size_t i = 0; i < ends.size(); ++i) mesh.vertex_ids.push_back(++id);
  }
  for (auto& [name, values] : mesh.point_arrays) {
    values.conservativeResize(Eigen::NoChange, mesh.vertex_count());
    Index v = corners;
    for (const auto& [a, b] : ends) values.col(v++) = 0.5 * (values.col(a) + values.col(b));
  }
  for (Group& group : mesh.groups) add_middles(mesh, edges, group);
  return mesh;
}

TetMesh without_edge_vertices(const TetMesh& mesh) {
  if (!mesh.is_quadratic()) return mesh;
  TetMesh result = mesh;
  result.edge_vertices.clear();
  std::vector<bool> is_corner(mesh.vertices.size(), false);
  for (const auto t : mesh.tetrahedra) {
    for (const Index v : t) is_corner[static_cast<std::size_t>(v)] = true;
  }
  std::vector<Index> kept;
  std::vector<Index> number(mesh.vertices.size(), -1);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (!is_corner[static_cast<std::size_t>(v)]) continue;
    number[static_cast<std::size_t>(v)] = static_cast<Index>(kept.size());
    kept.push_back(v);
  }
  const auto renumber = [&](Index& v) { v = number[static_cast<std::size_t>(v)]; };
  auto& vertices = result.vertices.own();
  vertices.clear();
  for (const Index v : kept) vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
  if (!mesh.vertex_ids.empty()) {
    result.vertex_ids.clear();
    for (const Index v : kept) result.vertex_ids.push_back(mesh.vertex_id(v));
  }
  for (auto& t : result.tetrahedra.own()) std::for_each(t.begin(), t.end(), renumber);
  for (auto& [name, values] : result.point_arrays) values = Matrix(values(Eigen::all, kept));
  for (Group& group : result.groups) {
    std::for_each(group.vertices.begin(), group.vertices.end(), renumber);
    std::erase(group.vertices, -1);
    for (auto& triangle : group.triangles) {
      std::for_each(triangle.begin(), triangle.end(), renumber);
    }
    for (auto& line : group.lines) std::for_each(line.begin(), line.end(), renumber);
  }
  return result;
}

}  // namespace tetraction
