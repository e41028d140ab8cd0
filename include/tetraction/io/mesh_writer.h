// Writes tetrahedral meshes to files.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// What became of the groups of a mesh in a file.
struct MeshWriteReport {
  /// Names of the groups that the file does not hold, or not with all of their cells.
  std::vector<std::string> lost_groups;
  /// How many of the cells given with the mesh the file holds.
  std::map<CellType, Index> cells;
};

/// The cells of a file that belong to groups and are not tetrahedra. build_mesh() keeps only the
/// vertices of such groups; write_mesh() can write the cells beside the mesh that was built.
std::vector<RawCell> group_cells(const RawMesh& raw);

/// Writes a mesh by the file name's ending: .vtu, .vtk (legacy), .msh (Gmsh 4.1 ASCII),
/// .node/.ele (TetGen, both files), .veg (Vega). Coordinates keep every bit, regions and the file's
/// own ids are kept where the format has a place for them:
///
/// - .vtu and .vtk keep ids and regions as arrays, and the point arrays of the mesh, but no groups.
/// - .msh keeps ids if all are at least 1, else shifts them to begin at 1; regions above 0 and
///   volume groups become physical groups, and so do the groups of the points, lines and triangles
///   in `cells` (group_cells() of the file that the mesh was built of). Groups keep their tags
///   unless a region has the number. Tetrahedra of region 0 get the tag of their last volume group
///   as region when the file is read.
/// - .node/.ele number from 0 if the mesh does, else from 1; regions become the attribute; groups
///   are not kept.
/// - .veg numbers from 1; volume groups become sets, and regions, if there are several, sets
///   `region_N` that a reader numbers in ascending order from 1.
///
/// Throws InputError for an unknown ending or an empty mesh, OutputError if the file cannot be
/// written; a file of that name then stays as it was.
MeshWriteReport write_mesh(const TetMesh& mesh, const std::string& path,
                           const std::vector<RawCell>& cells = {});

}  // namespace tetraction
