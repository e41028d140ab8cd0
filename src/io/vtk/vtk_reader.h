// VTK meshes: .vtu and legacy .vtk.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Reads with VTK's own readers in a child process: these crash, hang or ask for all memory on some
/// broken files, which then ends the child and becomes a FileError here.
/// Ids are the point and cell numbers from 0, or the arrays `vertex_id` and `element_id` if the
/// file carries them (as this program's own do). Floating-point point data and numbers of cells come along.
/// Appends what of the file is not used to `unused`. Throws FileError for a file that is malformed or
/// ambiguous, and for one with ghost cells.
RawMesh read_vtk_mesh(const std::string& path, std::vector<std::string>& unused);

}  // namespace tetraction
