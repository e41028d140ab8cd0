// Surfaces of triangles in STL, OBJ and VTP.
#pragma once

#include <string>

#include "io/mesh/triangle_mesh_reader.h"

namespace tetraction {

/// STL as text or binary. Throws FileError.
TriangleFile read_stl(const std::string& path);
/// Wavefront OBJ. Throws FileError.
TriangleFile read_obj(const std::string& path);

}  // namespace tetraction
