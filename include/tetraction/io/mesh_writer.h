// Writes tetrahedral meshes to files.
#pragma once

#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Writes a mesh by the file name's ending: .vtu, .vtk (legacy), .msh (Gmsh 4.1 ASCII),
/// .node/.ele (TetGen, both files), .veg (Vega). Coordinates keep every bit, regions and the file's
/// own ids are kept where the format has a place for them:
///
/// - .vtu and .vtk keep ids and regions as arrays, and the point arrays of the mesh, but no groups.
/// - .msh keeps ids if all are at least 1, else shifts them to begin at 1; regions above 0 and the
///   names of their volume groups become physical groups.
/// - .node/.ele number from 0 if the mesh does, else from 1; regions become the attribute.
/// - .veg numbers from 1; volume groups become sets, and regions, if there are several, sets
///   `region_N` that a reader numbers in ascending order from 1.
///
/// Throws InputError for an unknown ending or an empty mesh, OutputError if the file cannot be
/// written; a file of that name then stays as it was.
void write_mesh(const TetMesh& mesh, const std::string& path);

}  // namespace tetraction
