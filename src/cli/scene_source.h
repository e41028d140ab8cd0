// What run, study and check share: from the command line to a scene and its mesh.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The mesh of a scene, read or generated.
TetMesh load_mesh(const Scene& scene);

/// One line for people on what building the mesh changed and left out; empty if nothing.
std::string mesh_remarks(const TetMesh& mesh);

}  // namespace tetraction
