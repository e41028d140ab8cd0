// Makes a scene and its mesh from the command line, for run, study and check.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The mesh of a scene, read or generated.
TetMesh load_mesh(const Scene& scene);

/// One line for people that says what was changed or left out when the mesh was built. Empty if
/// nothing.
std::string mesh_remarks(const TetMesh& mesh);

}  // namespace tetraction
