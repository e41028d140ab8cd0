// Partitions of the graph whose nodes are the tetrahedra and whose edges are their common faces.
#pragma once

#include <vector>

#include "face_matches.h"

namespace tetraction::petsc {

/// The part, from 0, of each tetrahedron of the chunk when the mesh is cut into so many parts of nearly equal
/// numbers of tetrahedra with few common faces (PT-Scotch through PETSc's MatPartitioning; without it,
/// pieces of a Hilbert curve). `neighbors` is emptied. `processes` must be all those of MPI. Collective.
std::vector<int> partition_mesh(const MeshChunk& chunk,
                                std::vector<std::array<std::int32_t, 4>> neighbors, int parts,
                                const AllToAll& processes);

}  // namespace tetraction::petsc
