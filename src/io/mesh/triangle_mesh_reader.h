// Reads surfaces of triangles from files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Points and triangles as a file has them; STL repeats each point for every triangle.
struct TriangleFile {
  std::vector<Vector3> points;
  std::vector<std::array<Index, 3>> triangles;  ///< numbers of points, from 0
};

/// Reads a surface by the ending of the file's name:
///
/// - .stl, as text or binary; the normals are not used,
/// - .obj (Wavefront), points and faces; a face of more than three points is cut into a fan of triangles,
/// - .vtp, polygons (cut in the same way) and strips, read by VTK in a child process,
/// - .msh, .vtu, .vtk: the boundary of the tetrahedra, or if there are none, all triangles. Triangles of six
///   nodes of .msh become four.
///
/// Throws InputError for another ending, and FileError (file, line or place, what is wrong) for a file that is
/// missing, incomplete or malformed, or that has no triangle. A broken file never crashes or hangs the program.
/// Whether the triangles make a surface is checked by TriangleMesh.
TriangleFile read_triangle_file(const std::string& path);

}  // namespace tetraction
