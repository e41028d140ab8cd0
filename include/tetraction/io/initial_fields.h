// The mesh of a scene with the fields of its initial state.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Evaluates the displacement and the velocity field of the settings at every vertex of the mesh
/// and stores them in its point arrays under the names kInitialDisplacement and kInitialVelocity,
/// 3 × vertices, in m and m/s. Fields that the settings do not have are left alone.
///
/// A file has lines of comma-separated numbers: vertex,x,y,z with the vertex numbers of the mesh
/// file, where vertices without a line have zero; or x,y,z with one line for each vertex in the
/// mesh's order. Its first line may have the names of the columns, "vertex,x,y,z" or "x,y,z". A
/// formula is one of X, Y and Z, the rest position in m.
///
/// Throws FileError (file and line) for a file that is missing or malformed or does not fit the
/// mesh, and InputError for a formula that is wrong (key, formula, position) or whose value at a
/// vertex is not finite (the message names the vertex).
void add_initial_fields(const InitialSettings& initial, TetMesh& mesh);

/// The mesh of a scene, read or generated, with its initial fields. Throws as read_mesh(),
/// generate_mesh() and add_initial_fields() do.
TetMesh read_scene_mesh(const Scene& scene);
/// The same. Appends what of the mesh file is not used to `unused`, as read_raw_mesh() does.
TetMesh read_scene_mesh(const Scene& scene, std::vector<std::string>& unused);

}  // namespace tetraction
