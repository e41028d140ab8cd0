// The vertices in the middles of the edges of quadratic tetrahedra, by the ends of the edges.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

class EdgeVertices {
 public:
  /// No edges.
  EdgeVertices() = default;
  /// All edges of a quadratic mesh; none of a linear one.
  explicit EdgeVertices(const TetMesh& mesh);

  bool empty() const { return middles_.empty(); }
  /// The vertex in the middle of the edge between two corners, or −1 if there is no such edge.
  Index find(Index a, Index b) const {
    const auto found = middles_.find(key(a, b));
    return found == middles_.end() ? -1 : found->second;
  }
  /// Adds an edge with this vertex, unless it is there already. Returns its vertex.
  Index add(Index a, Index b, Index middle) {
    return middles_.emplace(key(a, b), middle).first->second;
  }
  /// The vertices of a face: its corners and the middles of its edges (01, 12, 20), if there are any.
  std::vector<Index> of_face(const std::array<Index, 3>& face) const;
  /// The faces, each of which is divided into four triangles by the middles of its edges if it has
  /// such. The triangles have the orientation of the face.
  std::vector<std::array<Index, 3>> divide(const std::vector<std::array<Index, 3>>& faces) const;

 private:
  static std::uint64_t key(Index a, Index b) {
    return (static_cast<std::uint64_t>(std::min(a, b)) << 32U) |
           static_cast<std::uint64_t>(std::max(a, b));
  }
  std::unordered_map<std::uint64_t, Index> middles_;
};

}  // namespace tetraction
