// Choosing vertices of a mesh by what a user can name.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Vertices by the numbers of the file.
struct SelectVertices {
  std::vector<std::int64_t> ids;
};
/// Vertices on the plane coordinate(axis) = at; `tolerance` in m, by default 1e-6 of the mesh's
/// bounding-box diagonal.
struct SelectPlane {
  int axis = 0;
  double at = 0.0;
  std::optional<double> tolerance;
};
/// Vertices inside a box, borders included.
struct SelectBox {
  Vector3 min = Vector3::Zero();
  Vector3 max = Vector3::Zero();
};
/// Vertices within `radius` of `center`.
struct SelectSphere {
  Vector3 center = Vector3::Zero();
  double radius = 0.0;
};
/// The one vertex nearest to a point (the lowest number among equals).
struct SelectNearest {
  Vector3 point = Vector3::Zero();
};
/// The vertices of a named group of the mesh file.
struct SelectGroup {
  std::string name;
};
/// The vertices of the boundary.
struct SelectSurface {};
/// Every vertex.
struct SelectAll {};

using Selection = std::variant<SelectVertices, SelectPlane, SelectBox, SelectSphere, SelectNearest,
                               SelectGroup, SelectSurface, SelectAll>;

/// The selected vertices in reference coordinates, as sorted internal numbers without repeats.
/// Throws InputError when nothing is selected, an id does not exist in the file, or a group is
/// unknown (the message lists the groups there are), and for an axis or a point that makes no sense.
std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection);

}  // namespace tetraction
