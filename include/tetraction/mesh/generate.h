// Meshes that the program generates.
#pragma once

#include <array>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// A box [0, size] of cells[0] × cells[1] × cells[2] cells, each cut into six tetrahedra around its
/// (0,0,0)–(1,1,1) diagonal. This is Kuhn's subdivision; neighbouring cells have matching faces.
/// Vertices are numbered along x first, then y, then z.
/// Throws InputError unless all sizes are positive and finite and all counts are at least 1. Also
/// throws it for more than 2e7 vertices and for volumes outside the range of double precision.
TetMesh generate_box(const Vector3& size, const std::array<int, 3>& cells);

/// The tetrahedron with the vertices (0,0,0), (1,0,0), (0,1,0), (0,0,1), multiplied by `size`.
TetMesh generate_tetrahedron(double size = 1.0);

}  // namespace tetraction
