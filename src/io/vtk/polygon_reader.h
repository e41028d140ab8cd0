// Surfaces of polygons in VTK's files.
#pragma once

#include <string>

#include "io/mesh/triangle_mesh_reader.h"

namespace tetraction {

/// Reads the polygons and strips of a .vtp file with VTK's reader in a child process, so that a broken file neither
/// crashes nor hangs the program. Throws FileError.
TriangleFile read_vtp(const std::string& path);

}  // namespace tetraction
