// Writes tetrahedral meshes to files.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The data of a mesh that a written file does not hold.
struct MeshWriteReport {
  /// Names of the groups that the file does not hold, or of which it holds only some cells.
  std::vector<std::string> lost_groups{};
  /// Names of the point and cell arrays that the file does not hold.
  std::vector<std::string> lost_arrays{};
  /// Whether tetrahedra are of another region, or of none, when the file is read.
  bool changed_regions = false;
  /// Names in a .msh file with a quotation mark. This program reads them as they are, Gmsh up to this mark.
  std::vector<std::string> names_with_quotes{};
};

/// The cells of a file that belong to groups and are not tetrahedra. build_mesh() keeps only the
/// vertices of such groups. write_mesh() can write these cells together with the mesh.
std::vector<RawCell> group_cells(const RawMesh& raw);

/// Writes a mesh by the file name's ending: .vtu, .vtk (legacy), .msh (Gmsh 4.1 ASCII),
/// .node/.ele (TetGen, both files), .veg (Vega). Coordinates keep every bit. Regions and the ids of
/// the original file are kept if the format has a place for them:
///
/// - .vtu and .vtk keep ids and regions as arrays, and the point and cell arrays of the mesh with other names
///   than these (`vertex_id`, `element_id`, `region`, `vtkGhost…`), but no groups.
/// - .msh keeps ids if all are at least 1. Otherwise they are shifted to begin at 1. Regions above
///   0 and volume groups become physical groups. So do the groups of the points, lines and
///   triangles in `cells` (group_cells() of the file that the mesh was built from). A group keeps
///   its tag unless a region has that number. When the file is read, tetrahedra of region 0 get the
///   tag of their last volume group as their region. Point and cell arrays of 1, 3 or 9 components
///   are kept as node and element data.
/// - .node/.ele count from 0 if the mesh does, otherwise from 1. Regions become the attribute.
///   Groups and arrays are not kept.
/// - .veg counts from 1. Volume groups become sets. If there are several regions, they become sets
///   `region_N`, which a reader numbers in ascending order from 1. Arrays are not kept.
///
/// Throws InputError for an unknown ending or an empty mesh. Throws OutputError if the file cannot
/// be written; an existing file of that name then stays as it was.
MeshWriteReport write_mesh(const TetMesh& mesh, const std::string& path,
                           const std::vector<RawCell>& cells = {});

}  // namespace tetraction
