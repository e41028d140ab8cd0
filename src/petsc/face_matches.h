// Which tetrahedra of a mesh have a face in common, and which faces are on its boundary.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh_chunk.h"

namespace tetraction::petsc {

/// The data of a process about the faces of a mesh that all processes hold in chunks.
struct FaceMatches {
  /// For each tetrahedron of the chunk, those that have a face in common with it, ascending, and then −1.
  std::vector<std::array<std::int32_t, 4>> neighbors;
  /// The faces that belong to one tetrahedron only and whose least vertex is in the chunk. Their vertices are
  /// ascending, and so are they.
  std::vector<std::array<Index, 3>> boundary;
  /// Such faces of the chunk's tetrahedra.
  struct OuterFace {
    Index tetrahedron;
    std::array<Index, 3> vertices;  ///< ascending
  };
  std::vector<OuterFace> of_tetrahedra;

  bool is_on_boundary(const std::array<Index, 3>& ascending) const;
};

/// The mesh must have fewer than 2³¹ vertices and tetrahedra. A face is matched by the process with its
/// least vertex. Collective.
FaceMatches match_faces(const MeshChunk& chunk, const AllToAll& processes);

}  // namespace tetraction::petsc
