// From chunks of a mesh to its parts.
#pragma once

#include <vector>

#include "face_matches.h"

namespace tetraction::petsc {

/// The data that a process exchanges with one other process.
struct Neighbor {
  int rank = 0;
  std::vector<Index>
      shared;  ///< vertices of the part that both have, in the order of the whole mesh
};

/// A part of a mesh as data.
struct PartData {
  TetMesh mesh;  ///< its own vertices come first
  Index owned_vertices = 0;
  std::vector<Neighbor> neighbors;  ///< ascending ranks
  std::vector<std::array<Index, 3>> boundary_faces;
  std::vector<Index> boundary_vertices;
  std::vector<Index> vertex_numbers;  ///< in the whole mesh
  MeshPart::Whole whole;
};

/// The part of this process, in which tetrahedra and vertices have the order of the whole mesh. part[i]: the
/// process that gets tetrahedron i of the chunk. No process needs memory for more than its chunk, its part and
/// what it sends and receives. Collective.
PartData collect_part(MeshChunk chunk, const std::vector<int>& part, const FaceMatches& faces,
                      const AllToAll& processes);

}  // namespace tetraction::petsc
