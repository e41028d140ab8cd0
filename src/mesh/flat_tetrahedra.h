// Whether a tetrahedron has a volume.
#pragma once

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The length of the longest edge of tetrahedron e, m.
double longest_edge(const TetMesh& mesh, Index e);

/// Whether a tetrahedron of this volume, m³, and longest edge, m, is flat up to round-off: |det| is below
/// 1e-14 of the cube of its longest edge. A volume that is not a number counts as flat.
bool is_flat(double volume, double longest);

}  // namespace tetraction
