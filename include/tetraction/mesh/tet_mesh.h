// The tetrahedral mesh. A reader makes a RawMesh from a file. build_mesh() checks it and makes a
// TetMesh, which the solver needs.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/mesh/mesh_arrays.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

/// Cell types that a reader can meet. Only tetrahedra become elements.
enum class CellType {
  kVertex,
  kLine,
  kTriangle,
  kQuadrilateral,
  kTetrahedron,
  kQuadraticTetrahedron,  ///< ten nodes; of files also more, which build_mesh() refuses
  kHexahedron,
  kWedge,
  kPyramid,
  kOther
};
template <>
struct EnumNames<CellType> {
  static constexpr std::array names{
      "vertex",     "line",  "triangle", "quadrilateral", "tetrahedron", "quadratic tetrahedron",
      "hexahedron", "wedge", "pyramid",  "other"};
};

/// One cell of a file. `vertices` are vertex ids as the file numbers them, in the order of VTK: the
/// corners, then the middles of the edges (of a tetrahedron as in TetMesh::edge_vertices).
struct RawCell {
  CellType type = CellType::kOther;
  std::int64_t id = 0;  ///< the file's own number of the cell
  std::vector<std::int64_t> vertices;
  int region = 0;           ///< cell data `region`, or 0
  std::vector<int> groups;  ///< indices into RawMesh::groups
};

/// A named set of cells of a file (Gmsh physical group, Vega set).
struct RawGroup {
  std::string name;
  int dimension = 3;
  int tag = 0;
};

/// The unchecked contents of a mesh file.
struct RawMesh {
  std::string source;  ///< file name, for messages
  std::vector<Vector3> vertices;
  std::vector<std::int64_t> vertex_ids;  ///< the file's own numbers, same length as `vertices`
  std::vector<RawCell> cells;
  std::vector<RawGroup> groups;
  std::map<std::string, Matrix> point_arrays;  ///< components × vertices, e.g. "displacement"
  std::map<std::string, Matrix> cell_arrays;   ///< components × cells
};

/// A named set of vertices, triangles and tetrahedra.
struct Group {
  std::string name;
  int dimension = 3;              ///< of the cells that define it: 0 point … 3 volume
  int tag = 0;                    ///< the file's number of the group
  std::vector<Index> vertices;    ///< sorted: all vertices of the group's cells
  std::vector<Index> tetrahedra;  ///< sorted; empty unless dimension is 3
  /// Empty unless dimension is 2. Those on the boundary have outward normals; others have the order
  /// of vertices of the file.
  std::vector<std::array<Index, 3>> triangles{};
  /// Triangles that have a vertex which no tetrahedron uses, with the vertex numbers of the file.
  std::vector<std::array<std::int64_t, 3>> detached_triangles{};
  std::vector<std::array<Index, 2>> lines{};  ///< their ends; empty unless dimension is 1
  /// How many lines are left out because no tetrahedron uses one of their ends.
  Index detached_lines = 0;
};

/// The changes and omissions of build_mesh(). It is meant for the user.
struct MeshReport {
  Index reoriented = 0;        ///< inverted tetrahedra whose vertex order was corrected
  Index dropped_vertices = 0;  ///< vertices that no tetrahedron uses
  std::map<CellType, Index> skipped_cells;
};

/// A checked tetrahedral mesh: positive volumes, finite coordinates, every vertex used.
///
/// The library numbers vertices and tetrahedra from 0. `vertex_ids` and `tetrahedron_ids` hold the
/// numbers of the file, which a user gives in selections and sees in outputs. These two and
/// `regions` have one entry per vertex or tetrahedron, or they are empty; then ids count from 0 and
/// every tetrahedron is in region 0. Positions and tetrahedra may be views of the caller's arrays
/// (view_mesh()).
struct TetMesh {
  std::string source;
  VertexArray vertices;         ///< rest positions X, m
  TetrahedronArray tetrahedra;  ///< linear: det[X1−X0, X2−X0, X3−X0] > 0
  std::vector<std::int64_t> vertex_ids;
  std::vector<std::int64_t> tetrahedron_ids;
  std::vector<int> regions;  ///< per tetrahedron
  std::vector<Group> groups;
  std::map<std::string, Matrix> point_arrays;  ///< components × vertices
  MeshReport report;
  std::map<std::string, Matrix> cell_arrays{};  ///< components × tetrahedra
  /// Empty for linear tetrahedra. For quadratic ones the vertices in the middles of the edges 01, 12,
  /// 02, 03, 13 and 23 of each tetrahedron (the order of VTK); `tetrahedra` has the corners.
  std::vector<std::array<Index, 6>> edge_vertices{};
  /// The whole that this mesh is a part of, where several processes hold a mesh together; null for a whole one.
  SharedMeshPart part{};

  bool is_quadratic() const { return !edge_vertices.empty(); }
  Index vertex_count() const { return static_cast<Index>(vertices.size()); }
  Index tetrahedron_count() const { return static_cast<Index>(tetrahedra.size()); }
  /// The number of a vertex in the file. Messages and results show this number.
  std::int64_t vertex_id(Index v) const {
    return vertex_ids.empty() ? v : vertex_ids[static_cast<std::size_t>(v)];
  }
  /// The number of a tetrahedron in the file. Messages and results show this number.
  std::int64_t tetrahedron_id(Index e) const {
    return tetrahedron_ids.empty() ? e : tetrahedron_ids[static_cast<std::size_t>(e)];
  }
  int region(Index e) const { return regions.empty() ? 0 : regions[static_cast<std::size_t>(e)]; }

  /// Rest positions as one DOF-ordered vector (3 per vertex), m.
  Vector rest_positions() const;
  /// Signed volume of tetrahedron `e` with its curved edges, exactly, m³.
  double volume(Index e) const;
  /// Sum of the volumes, m³; of a part, the volume of the whole mesh.
  double total_volume() const;
};

/// Checks a raw mesh and makes the solver's mesh of it. All coordinates are multiplied by `scale`.
///
/// The function takes the tetrahedra, linear or quadratic, and the triangles of groups, counts other
/// cells in the report, reorients inverted tetrahedra, and drops vertices that no tetrahedron uses.
/// Throws FileError, which names the file and the id of the element or vertex, for: no tetrahedra,
/// tetrahedra of both orders or of a higher one, a vertex in the middle of an edge that is more than
/// half of the edge away from there or differs between elements, curved edges that turn an element
/// inside out at a quadrature point, a vertex id that does not exist, a NaN or infinite coordinate, a repeated
/// vertex in a tetrahedron, a volume of zero (below 1e-14 of the cube of the longest edge), and a
/// vertex number that occurs twice. Throws InputError unless the scale is positive and finite.
TetMesh build_mesh(RawMesh raw, double scale = 1.0);

/// A mesh that uses the caller's own arrays without a copy: three coordinates per vertex, m, and
/// the four vertices of each tetrahedron, numbered from 0.
///
/// Both arrays must live longer than the mesh, its copies and every body made of them, and they
/// must not change meanwhile. Ids count from 0. There are no regions and no groups. The arrays must
/// be correct already, because view_mesh() corrects nothing and leaves nothing out. Throws InputError,
/// which names the tetrahedron or vertex, for: arrays that are empty or whose lengths are no
/// multiples of 3 and 4, a vertex that does not exist, a NaN or infinite coordinate, a volume that
/// is not positive (as build_mesh() judges it), a vertex that no tetrahedron uses.
TetMesh view_mesh(std::span<const double> positions, std::span<const std::int32_t> tetrahedra);
TetMesh view_mesh(std::span<const double> positions, std::span<const std::int64_t> tetrahedra);

/// The corners of the edges of a tetrahedron, in the order of TetMesh::edge_vertices.
constexpr std::array<std::array<std::size_t, 2>, 6> kTetrahedronEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

/// The mesh with quadratic tetrahedra: every edge of a linear mesh gets a vertex in its middle, after
/// all other vertices. Their ids follow the largest one. Point arrays have the mean of both ends there.
/// A group of tetrahedra or triangles gets the middles of their edges; a group of lines or points
/// gets the middles of edges between its vertices. A quadratic mesh is returned as it is.
TetMesh with_edge_vertices(TetMesh mesh);
/// The mesh with linear tetrahedra: the vertices in the middles of edges are left out.
TetMesh without_edge_vertices(const TetMesh& mesh);

/// The mesh with each tetrahedron divided into eight by the middles of its edges. The vertices of the coarse
/// mesh come first and keep their numbers; tetrahedra are numbered anew. Groups, regions and cell arrays are those of
/// the tetrahedron, triangle or line that was divided. A quadratic mesh remains quadratic, and its curved edges keep
/// their form: the new vertices are points of the coarse tetrahedra, and point arrays have the values there.
TetMesh refined_mesh(const TetMesh& mesh);

/// The faces that belong to one tetrahedron only. Their vertices are ordered so that normals point
/// outward. Of a part (TetMesh::part) they are its faces on the boundary of the whole mesh.
std::vector<std::array<Index, 3>> boundary_faces(const TetMesh& mesh);

}  // namespace tetraction
