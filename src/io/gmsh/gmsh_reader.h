// Gmsh meshes (.msh), formats 1, 2 and 4.1, ASCII and binary.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Ids are Gmsh's node and element tags; physical groups become groups, and the tag of a volume
/// group its elements' region. Appends what of the file is not used to `unused`, a text for each thing.
/// Throws FileError if the file is incomplete, malformed or ambiguous.
RawMesh read_gmsh(const std::string& path, std::vector<std::string>& unused);

}  // namespace tetraction
