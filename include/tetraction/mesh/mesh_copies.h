// Several bodies from one mesh.
#pragma once

#include <span>
#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The place of a copy of a mesh.
struct MeshPlace {
  Vector3 at = Vector3::Zero();  ///< displacement, m
  Vector3 turn = Vector3::
      Zero();  ///< rotation vector about the middle of the mesh's box, degrees; before `at`
};

/// The mesh with copies of itself at these places, in their order, as one mesh. Numbers of vertices and tetrahedra of copy
/// k are those of the mesh plus k times the first number that it does not use. Groups contain all copies, and there is
/// a new group of each body, group_of_copy(k), where 0 is the mesh itself. Arrays are repeated as they are.
/// Throws InputError if a group has the name of a new one.
TetMesh with_copies(TetMesh mesh, std::span<const MeshPlace> places);

/// "body_0", "body_1", …
std::string group_of_copy(std::size_t k);

}  // namespace tetraction
