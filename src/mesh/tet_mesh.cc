#include "tetraction/mesh/tet_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

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
  // The faces of a tetrahedron with positive volume, with outward normals.
  constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{
      {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  struct Face {
    std::array<Index, 3> key;
    std::array<Index, 3> face;
  };
  // Faces are compared by ranges of their smallest vertex: all of them together would need five times the
  // memory of the mesh.
  constexpr Index kTogether = 1 << 17;  // tetrahedra
  const Index passes = std::clamp<Index>(mesh.tetrahedron_count() / kTogether, 1, 16);
  std::vector<Face> faces;
  std::vector<std::array<Index, 3>> boundary;
  for (Index pass = 0; pass < passes; ++pass) {
    const Index low = mesh.vertex_count() * pass / passes;
    const Index high = mesh.vertex_count() * (pass + 1) / passes;
    faces.clear();
    for (const auto t : mesh.tetrahedra) {
      for (const auto& f : kFaces) {
        const std::array<Index, 3> face{t[f[0]], t[f[1]], t[f[2]]};
        const Index least = std::min({face[0], face[1], face[2]});
        if (least < low || least >= high) continue;
        faces.push_back({face, face});
        std::sort(faces.back().key.begin(), faces.back().key.end());
      }
    }
    std::sort(faces.begin(), faces.end(),
              [](const Face& a, const Face& b) { return a.key < b.key; });
    for (std::size_t i = 0; i < faces.size();) {
      std::size_t next = i + 1;
      while (next < faces.size() && faces[next].key == faces[i].key) ++next;
      if (next == i + 1) boundary.push_back(faces[i].face);
      i = next;
    }
  }
  return boundary;
}

}  // namespace tetraction
