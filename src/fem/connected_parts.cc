#include "connected_parts.h"

#include <numeric>
#include <utility>

namespace tetraction {

std::vector<std::vector<Index>> connected_parts(const RestState& rest,
                                                const std::vector<AffineSet>& sets) {
  std::vector<Index> parent(static_cast<std::size_t>(rest.vertex_count()));
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      Index& up = parent[static_cast<std::size_t>(v)];
      up = parent[static_cast<std::size_t>(up)];
      v = up;
    }
    return v;
  };
  const auto join = [&](Index a, Index b) { parent[static_cast<std::size_t>(root(a))] = root(b); };
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    for (const Index v : nodes) join(nodes[0], v);
  }
  for (const AffineSet& set : sets) {
    for (const Index v : set.vertices) join(set.vertices.front(), v);
  }
  std::vector<std::vector<Index>> parts;
  std::vector<Index> number(parent.size(), -1);
  for (Index v = 0; v < rest.vertex_count(); ++v) {
    Index& part = number[static_cast<std::size_t>(root(v))];
    if (part < 0) {
      part = static_cast<Index>(parts.size());
      parts.emplace_back();
    }
    parts[static_cast<std::size_t>(part)].push_back(v);
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
