#include "mesh_pieces.h"

#include <algorithm>
#include <array>

#include "core/disjoint_sets.h"
#include "face_groups.h"

namespace tetraction {
namespace {

// For each tetrahedron the number of its piece, and the number of pieces.
std::vector<Index> numbers_of_pieces(const TetMesh& mesh, Index& count) {
  DisjointSets pieces(mesh.tetrahedron_count());
  for_each_face_group(mesh, 0, mesh.vertex_count(), [&](std::span<const Index> group) {
    for (std::size_t i = 1; i < group.size(); ++i) pieces.join(group[i] / 4, group[i - 1] / 4);
  });
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
