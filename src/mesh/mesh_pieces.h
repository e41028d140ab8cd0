// The pieces of a mesh that hang together through faces.
#pragma once

#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Tetrahedra that hang together through faces. Two pieces may touch in edges and in single vertices, which
/// carry no moment.
struct MeshPiece {
  std::vector<Index> vertices;  ///< sorted, with those in the middles of edges
  Index tetrahedra = 0;
};

/// The pieces in the order of their first tetrahedra.
std::vector<MeshPiece> mesh_pieces(const TetMesh& mesh);

}  // namespace tetraction
