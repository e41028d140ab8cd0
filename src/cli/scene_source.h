// Notes about a scene and its mesh for people, for the commands that read them.
#pragma once

#include <string>
#include <vector>

#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// One line for people that says what was changed or left out when the mesh was built, and what of its file
/// is not used. Empty if nothing.
std::string mesh_remarks(const TetMesh& mesh, const std::vector<std::string>& unused = {});

/// One line that says what mass damping and viscosity the scene's damping.ratio gives, and what
/// damping ratios they have in shear, bending and changes of volume. Empty without damping.ratio.
std::string damping_remarks(const Scene& scene);

/// Why the limit is smaller than 2/omega_max, "; the damping lowers it: …". Empty if it is not.
std::string damping_of_limit(const StabilityLimit& limit);

}  // namespace tetraction
