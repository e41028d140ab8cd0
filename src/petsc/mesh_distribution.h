// From a mesh that one process has read to the parts of all processes.
#pragma once

#include "processes.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::petsc {

/// Gives every process its part of the mesh that process 0 has; the meshes of others are ignored. Process 0
/// sends equal ranges of the mesh, one at a time, and releases the mesh. From then on no process has more than its
/// share: all of them find the neighbours of the tetrahedra, the partition (PT-Scotch) and the parts together.
/// The result is the mesh of the part, whose TetMesh::part talks to the other processes and makes
/// preconditioners (PreconditionerSource). Throws InputError if the mesh has fewer tetrahedra than there are processes,
/// or more than PETSc can number. Collective.
TetMesh distribute_mesh(const Processes& processes, TetMesh mesh);

}  // namespace tetraction::petsc
