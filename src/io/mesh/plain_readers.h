// TetGen (.node/.ele) and Vega (.veg) meshes.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Reads NAME.node and NAME.ele, given either, and NAME.face if there is one. Numbers from 0 or 1 are
/// kept as ids; the first attribute of an element becomes its region. The faces of each boundary marker
/// but 0 become a group with the marker as its name. Appends what of the files is not used to `unused`.
/// Throws FileError.
RawMesh read_tetgen(const std::string& path, std::vector<std::string>& unused);

/// Reads *VERTICES and *ELEMENTS (TET, CUBIC); *SET become groups, and the order of *REGION lines
/// the regions of their sets. Appends what of the file is not used to `unused`. Throws FileError.
RawMesh read_vega(const std::string& path, std::vector<std::string>& unused);

}  // namespace tetraction
