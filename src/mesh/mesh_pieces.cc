#include "mesh_pieces.h"

#include <algorithm>
#include <array>

#include "core/disjoint_sets.h"

namespace tetraction {
namespace {

// For each tetrahedron the number of its piece, and the number of pieces.
std::vector<Index> numbers_of_pieces(const TetMesh& mesh, Index& count) {
  DisjointSets pieces(mesh.tetrahedron_count());
  struct Face {
    std::array<Index, 3> vertices;  // sorted
    Index tetrahedron;
    bool operator<(const Face& other) const { return vertices < other.vertices; }
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    std::array<Index, 4> t = mesh.tetrahedra[static_cast<std::size_t>(e)];
    std::sort(t.begin(), t.end());
    for (const auto& face : {std::array{t[0], t[1], t[2]}, std::array{t[0], t[1], t[3]},
                             std::array{t[0], t[2], t[3]}, std::array{t[1], t[2], t[3]}}) {
      faces.push_back({face, e});
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].vertices != faces[i - 1].vertices) continue;
    pieces.join(faces[i].tetrahedron, faces[i - 1].tetrahedron);
  }
  return pieces.numbers(count);
}

}  // namespace

std::vector<MeshPiece> mesh_pieces(const TetMesh& mesh) {
  Index count = 0;
  const std::vector<Index> numbers = numbers_of_pieces(mesh, count);
  std::vector<MeshPiece> pieces(static_cast<std::size_t>(count));
  for (std::size_t e = 0; e < numbers.size(); ++e) {
    MeshPiece& piece = pieces[static_cast<std::size_t>(numbers[e])];
    ++piece.tetrahedra;
    const std::array<Index, 4> corners = mesh.tetrahedra[e];
    piece.vertices.insert(piece.vertices.end(), corners.begin(), corners.end());
    if (!mesh.is_quadratic()) continue;
    const auto& middles = mesh.edge_vertices[e];
    piece.vertices.insert(piece.vertices.end(), middles.begin(), middles.end());
  }
  for (MeshPiece& piece : pieces) {
    std::sort(piece.vertices.begin(), piece.vertices.end());
    piece.vertices.erase(std::unique(piece.vertices.begin(), piece.vertices.end()),
                         piece.vertices.end());
  }
  return pieces;
}

}  // namespace tetraction
