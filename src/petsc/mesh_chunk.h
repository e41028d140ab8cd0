// A range of the vertices and a range of the tetrahedra of a mesh: what a process has of the mesh before it is
// cut into parts.
#pragma once

#include <cstddef>
#include <vector>

#include "all_to_all.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::petsc {

inline std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// The vertices from `first_vertex` on and the tetrahedra from `first_tetrahedron` on.
struct MeshChunk {
  Index first_vertex = 0;
  Index first_tetrahedron = 0;
  /// Vertices and tetrahedra have the numbers of the whole mesh in all lists. Ids are never empty. A group has those of its
  /// vertices and tetrahedra that are in the ranges, and the triangles and lines whose least vertex is.
  TetMesh mesh;
  MeshPart::Whole whole;

  EqualRanges vertex_ranges(int processes) const { return {whole.vertices, processes}; }
  EqualRanges tetrahedron_ranges(int processes) const { return {whole.tetrahedra, processes}; }
};

/// The data of a mesh that all processes have.
MeshPart::Whole whole_of(const TetMesh& mesh);

/// The chunk of process `number` out of so many (EqualRanges).
MeshChunk chunk_of(const TetMesh& mesh, const MeshPart::Whole& whole, int number, int processes);

/// The chunk as bytes, and back.
std::vector<char> packed(MeshChunk chunk);
MeshChunk unpacked_chunk(std::vector<char> bytes);

}  // namespace tetraction::petsc
