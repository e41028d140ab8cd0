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

/// One line that says what mass damping and viscosity the scene's damping.ratio gives, and what
/// damping ratios they have in shear, bending and changes of volume. Empty without damping.ratio.
std::string damping_remarks(const Scene& scene);

}  // namespace tetraction
