// Ways in which a user can select vertices, triangles and tetrahedra of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/core/enum_names.h"
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

/// The boundary triangles whose outward unit normal at rest is within `angle` (degrees, 0 to 180) of
/// `normal`; their vertices if vertices are selected. Angles are compared to 1e-6 degrees.
struct SelectFaces {
  Vector3 normal = Vector3::Zero();  ///< of any length but zero
  double angle = 30.0;
  bool operator==(const SelectFaces&) const = default;
};

struct SelectionPart;

enum class SetOperation { kAllOf, kAnyOf, kNot };
template <>
struct EnumNames<SetOperation> {
  static constexpr std::array names{"all_of", "any_of", "not"};
};

/// The intersection of all parts, their union, or the complement of the only part. A part may select nothing.
struct SelectSet {
  SetOperation operation = SetOperation::kAllOf;
  std::vector<SelectionPart> of;  ///< one or more; exactly one for kNot
  bool operator==(const SelectSet&) const;
};
/// A selection that has a name in the scene. The scene writer writes the name; the selection itself
/// must then be in Scene::selection.
struct SelectNamed {
  std::string name;
  std::vector<SelectionPart> of;  ///< exactly one
  bool operator==(const SelectNamed&) const;
};

using Selection =
    std::variant<SelectVertices, SelectPlane, SelectBox, SelectSphere, SelectNearest, SelectGroup,
                 SelectSurface, SelectAll, SelectFaces, SelectSet, SelectNamed>;

/// One operand of a set.
struct SelectionPart {
  Selection selection;
  bool operator==(const SelectionPart&) const = default;
};

/// The selected vertices as sorted internal numbers without repeats. Coordinates in selections are
/// rest positions. Sets are sets of vertices. Throws InputError if nothing is selected, if an id
/// does not exist in the file, if a group is unknown (the message lists the groups of the mesh),
/// for an invalid axis, point or normal, and for a set or a named selection with a wrong number of
/// parts.
///
/// For a part (TetMesh::part) this and the following functions return what is selected in the part, which
/// may be nothing, and all processes must call them.
std::vector<Index> select_vertices(const TetMesh& mesh, const Selection& selection);

/// The selected tetrahedra, sorted. A group that consists of tetrahedra selects these. A box or a
/// sphere selects the tetrahedra whose centroid is inside. Sets are sets of tetrahedra. Any other
/// selection selects the tetrahedra with all four vertices selected. Throws InputError as
/// select_vertices() does, and if no tetrahedron is selected.
std::vector<Index> select_tetrahedra(const TetMesh& mesh, const Selection& selection);

/// The selected triangles of the boundary in the order of boundary_faces(), with outward normals.
///
/// A SelectFaces and a group of dimension 2 select their own triangles. If a selection contains one
/// of these, its sets are sets of boundary triangles, and any other part selects the triangles with
/// all three vertices selected. A selection without such a part selects the triangles whose three
/// vertices are all in select_vertices(). Throws InputError as select_vertices() does, if no
/// triangle is selected, and for a group with a triangle that is not on the boundary; the message
/// names the group and the vertices of the triangle.
std::vector<std::array<Index, 3>> select_triangles(const TetMesh& mesh, const Selection& selection);

}  // namespace tetraction
