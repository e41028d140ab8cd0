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
  bool operator==(const SelectVertices&) const = default;
};
/// Vertices on the plane coordinate(axis) = at; `tolerance` in m, by default 1e-6 of the mesh's
/// bounding-box diagonal.
struct SelectPlane {
  int axis = 0;
  double at = 0.0;
  std::optional<double> tolerance;
  bool operator==(const SelectPlane&) const = default;
};
/// Vertices inside a box, borders included.
struct SelectBox {
  Vector3 min = Vector3::Zero();
  Vector3 max = Vector3::Zero();
  bool operator==(const SelectBox&) const = default;
};
/// Vertices within `radius` of `center`.
struct SelectSphere {
  Vector3 center = Vector3::Zero();
  double radius = 0.0;
  bool operator==(const SelectSphere&) const = default;
};
/// The one vertex nearest to a point (the lowest number among equals).
struct SelectNearest {
  Vector3 point = Vector3::Zero();
  bool operator==(const SelectNearest&) const = default;
};
/// The vertices of a named group of the mesh file.
struct SelectGroup {
  std::string name;
  bool operator==(const SelectGroup&) const = default;
};
/// The vertices of the boundary.
struct SelectSurface {
  bool operator==(const SelectSurface&) const = default;
};
/// Every vertex.
struct SelectAll {
  bool operator==(const SelectAll&) const = default;
};

using Selection = std::variant<SelectVertices, SelectPlane, SelectBox, SelectSphere, SelectNearest,
                               SelectGroup, SelectSurface, SelectAll>;

/// The selected vertices in reference coordinates, as sorted internal numbers without repeats.
/// Throws InputError when nothing is selected, an id does not exist in the file, or a group is
/// unknown (the message lists the groups there are), and for an axis or a point that makes no sense.
std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection);

/// The selected tetrahedra, sorted: of a group that consists of tetrahedra those, of a box or a
/// sphere those with their centroid in it, of anything else those with all four vertices selected.
/// Throws InputError as select_vertices() does, and when no tetrahedron is selected.
std::vector<Index> select_tetrahedra(const TetMesh& mesh, const Selection& selection);

}  // namespace tetraction
