// Gmsh meshes (.msh), formats 2.2 and 4.1, ASCII and binary.
#pragma once

#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Ids are Gmsh's node and element tags; physical groups become groups, and the tag of a volume
/// group its elements' region. Throws FileError if the file is incomplete or malformed.
RawMesh read_gmsh(const std::string& path);

}  // namespace tetraction
