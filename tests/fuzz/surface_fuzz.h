// What the targets of surfaces of triangles check.
#pragma once

#include <cmath>

#include "dynamics/contact/mesh/triangle_mesh.h"
#include "fuzz_target.h"
#include "io/mesh/triangle_mesh_reader.h"

namespace tetraction::fuzzing {

/// Reads a surface and makes an obstacle of it. What the reader gives has triangles of points that exist and
/// are finite; the obstacle's triangles have normals.
inline void check_surface(const std::string& name, std::string_view text) {
  const std::string path = written(name, text);
  TriangleFile file;
  if (!accepted([&] { file = read_triangle_file(path); })) return;
  if (file.triangles.empty()) fail("a surface without triangles");
  const auto count = static_cast<Index>(file.points.size());
  for (const std::array<Index, 3>& triangle : file.triangles) {
    for (const Index i : triangle) {
      if (i < 0 || i >= count) fail("a corner that does not exist");
    }
  }
  for (const Vector3& point : file.points) {
    if (!point.allFinite()) fail("a point that is not finite");
  }
  accepted([&] {
    const TriangleMesh mesh(file.points, file.triangles);
    for (Index t = 0; t < mesh.first_edge(); ++t) {
      // The projector n nᵀ of a triangle has the trace |n|².
      if (!(std::abs(mesh.projector(t).trace() - 1.0) < 1e-6)) fail("a triangle without a normal");
    }
  });
}

}  // namespace tetraction::fuzzing
