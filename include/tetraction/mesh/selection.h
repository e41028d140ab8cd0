// Ways in which a user can select vertices of a mesh.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The vertices with the given numbers; the numbers are those of the mesh file.
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
/// The vertex nearest to a point. If several are equally near, the one with the lowest number.
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

/// The selected vertices as sorted internal numbers without repeats. Coordinates in selections are
/// rest positions. Throws InputError if nothing is selected, if an id does not exist in the file,
/// if a group is unknown (the message lists the groups of the mesh), and for an invalid axis or
/// point.
std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection);

/// The selected tetrahedra, sorted. A group that consists of tetrahedra selects these. A box or a
/// sphere selects the tetrahedra whose centroid is inside. Any other selection selects the
/// tetrahedra with all four vertices selected. Throws InputError as select_vertices() does, and if
/// no tetrahedron is selected.
std::vector<Index> select_tetrahedra(const TetMesh& mesh, const Selection& selection);

}  // namespace tetraction
