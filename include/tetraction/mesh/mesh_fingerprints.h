// Numbers by which a mesh can be told from others.
#pragma once

#include <cstdint>

namespace tetraction {

struct TetMesh;

/// Numbers made from all data of a mesh. Meshes with the same numbers are taken for the same mesh.
struct MeshFingerprints {
  /// Made from the positions, the tetrahedra, their order, and the fields over the tetrahedra.
  std::uint64_t body = 0;
  /// Made from the numbers of vertices and tetrahedra in the mesh file, and from the groups.
  std::uint64_t numbers = 0;
  /// Made from the fields over the vertices (TetMesh::point_arrays).
  std::uint64_t fields = 0;
};

/// The numbers of a mesh. Those of a part of a mesh (TetMesh::part) are the numbers of the whole mesh.
MeshFingerprints fingerprints_of(const TetMesh& mesh);

}  // namespace tetraction
