// Reads tetrahedral meshes from files.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Reads a mesh by the file name's ending: .vtu, .vtk, .msh (Gmsh 1, 2 and 4.1, ASCII, from version
/// 2 on also binary), .node or .ele (TetGen, both files, and .face), .veg (Vega). Only the format of the file
/// is checked here; build_mesh() checks the mesh. Throws InputError for another ending, and
/// FileError (file, line or section, what is wrong) for a file that is incomplete or malformed, that
/// could be read in two ways (a section, an array or a number given twice), or that has ghost cells. A
/// broken file never crashes or hangs the program.
RawMesh read_raw_mesh(const std::string& path);
/// The same. Appends a text to `unused` for each thing that the file has and that is not used, such as names
/// of groups without elements and sections that are not read.
RawMesh read_raw_mesh(const std::string& path, std::vector<std::string>& unused);

/// read_raw_mesh() and build_mesh().
TetMesh read_mesh(const std::string& path, double scale = 1.0);
TetMesh read_mesh(const std::string& path, double scale, std::vector<std::string>& unused);

}  // namespace tetraction
