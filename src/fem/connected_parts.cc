#include "connected_parts.h"

#include <utility>

#include "core/disjoint_sets.h"

namespace tetraction {

std::vector<std::vector<Index>> connected_parts(const RestState& rest,
                                                const std::vector<AffineSet>& sets) {
  DisjointSets joined(rest.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    for (const Index v : nodes) joined.join(nodes[0], v);
  }
  for (const AffineSet& set : sets) {
    for (const Index v : set.vertices) joined.join(set.vertices.front(), v);
  }
  Index count = 0;
  const std::vector<Index> part = joined.numbers(count);
  std::vector<std::vector<Index>> parts(static_cast<std::size_t>(count));
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    parts[static_cast<std::size_t>(part[static_cast<std::size_t>(v)])].push_back(v);
  }
  return parts;
}

std::vector<std::vector<MeshPiece>> pieces_of_parts(const TetMesh& mesh,
                                                    const std::vector<std::vector<Index>>& parts) {
  std::vector<std::size_t> part_of(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    for (const Index v : parts[k]) part_of[static_cast<std::size_t>(v)] = k;
  }
  std::vector<std::vector<MeshPiece>> pieces(parts.size());
  for (MeshPiece& piece : mesh_pieces(mesh)) {
    pieces[part_of[static_cast<std::size_t>(piece.vertices.front())]].push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace tetraction
