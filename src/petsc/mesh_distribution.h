// From a mesh that one process has read to the parts of all processes.
#pragma once

#include <vector>

#include "processes.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::petsc {

/// part[e]: the part, from 0, of tetrahedron e when the mesh is cut into so many parts of nearly equal
/// numbers of tetrahedra with few common faces (PT-Scotch through PETSc's MatPartitioning; without it,
/// pieces of a Hilbert curve).
std::vector<int> partition_mesh(const TetMesh& mesh, int parts);

/// What a process exchanges with one other process.
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

/// Cuts parts out of a mesh, one at a time.
class MeshDivider {
 public:
  /// Keeps references to both.
  MeshDivider(const TetMesh& mesh, const std::vector<int>& part_of_tetrahedron, int parts);

  PartData part(int number) const;

 private:
  const TetMesh& mesh_;
  std::vector<std::vector<Index>> tetrahedra_;  // of each part, ascending
  // The parts that use vertex v, ascending: sharers_[first_[v]] to sharers_[first_[v + 1] − 1].
  std::vector<std::size_t> first_;
  std::vector<int> sharers_;
  std::vector<std::array<Index, 3>> boundary_;  // sorted vertices, sorted
  std::vector<std::uint8_t> on_boundary_;       // per vertex
  MeshPart::Whole whole_;
};

/// Gives every process its part of the mesh that process 0 has; the meshes of others are ignored. Process 0
/// needs memory for one part at a time beside the mesh. The result is the mesh of the part, whose
/// TetMesh::part talks to the other processes and makes preconditioners (PreconditionerSource). Throws InputError if
/// the mesh has fewer tetrahedra than there are processes. Collective.
TetMesh distribute_mesh(const Processes& processes, TetMesh mesh);

}  // namespace tetraction::petsc
