// Writes tetrahedral meshes to files.
#pragma once

#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Writes a mesh by the file name's ending: .vtu, .vtk (legacy), .msh (Gmsh 4.1 ASCII),
/// .node/.ele (TetGen, both files), .veg (Vega). Coordinates keep all 17 digits, regions and the
/// file's own ids are kept where the format has a place for them: .vtu and .vtk keep both, .msh ids
/// from 1 up (others are shifted), TetGen and Vega are numbered in a row.
/// Throws InputError for an unknown ending, OutputError if the file cannot be written.
void write_mesh(const TetMesh& mesh, const std::string& path);

}  // namespace tetraction
