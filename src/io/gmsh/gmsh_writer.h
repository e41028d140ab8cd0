// Writes Gmsh files.
#pragma once

#include <string>
#include <vector>

#include "tetraction/io/mesh_writer.h"

namespace tetraction {

/// Writes version 4.1 as text; `cells` and the result as in write_mesh().
MeshWriteReport write_gmsh(const TetMesh& mesh, const std::string& path,
                           const std::vector<RawCell>& cells);

}  // namespace tetraction
