// Likely mistakes in meshes that build_mesh() accepts.
#pragma once

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The number of vertices at exactly the place of an earlier one. Parts of a body that touch only in
/// such vertices do not hang together.
Index coincident_vertices(const TetMesh& mesh);

}  // namespace tetraction
