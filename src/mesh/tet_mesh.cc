#include "tetraction/mesh/tet_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "face_groups.h"
#include "quadratic_rules.h"

namespace tetraction {

Vector TetMesh::rest_positions() const {
  Vector x(3 * vertex_count());
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(x, v) = vertices[static_cast<std::size_t>(v)];
  }
  return x;
}

double TetMesh::volume(Index e) const {
  if (is_quadratic()) return curved_volume(rest_edges_at_points(*this, e));
  const auto t = tetrahedra[static_cast<std::size_t>(e)];
  const auto vertex = [this](Index v) { return vertices[static_cast<std::size_t>(v)]; };
  const Vector3 a = vertex(t[1]) - vertex(t[0]);
  const Vector3 b = vertex(t[2]) - vertex(t[0]);
  const Vector3 c = vertex(t[3]) - vertex(t[0]);
  return a.dot(b.cross(c)) / 6.0;
}

double TetMesh::total_volume() const {
  if (part) return part->whole.volume;
  double sum = 0.0;
  for (Index e = 0; e < tetrahedron_count(); ++e) sum += volume(e);
  return sum;
}

std::vector<std::array<Index, 3>> boundary_faces(const TetMesh& mesh) {
  if (mesh.part) return mesh.part->boundary_faces;
  // Faces are compared by ranges of their smallest vertex: all of them together would need three times the
  // memory of the mesh.
  constexpr Index kTogether = 1 << 17;  // tetrahedra
  const Index passes = std::clamp<Index>(mesh.tetrahedron_count() / kTogether, 1, 16);
  std::vector<std::array<Index, 3>> boundary;
  for (Index pass = 0; pass < passes; ++pass) {
    const Index low = mesh.vertex_count() * pass / passes;
    const Index high = mesh.vertex_count() * (pass + 1) / passes;
    for_each_face_group(mesh, low, high, [&](std::span<const Index> group) {
      if (group.size() != 1) return;
      const std::array<Index, 4> t = mesh.tetrahedra[static_cast<std::size_t>(group[0] / 4)];
      const auto& corners = kFaceCorners[static_cast<std::size_t>(group[0] % 4)];
      boundary.push_back({t[corners[0]], t[corners[1]], t[corners[2]]});
    });
  }
  return boundary;
}

}  // namespace tetraction
