// The groups that a name in a selection stands for.
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The groups of this name. If there are none, those that a name with the dimension or with dimension and
/// tag describes, as in "part (dimension 2)" and "part (dimension 2, tag 7)".
std::vector<const Group*> groups_named(const TetMesh& mesh, const std::string& name);

/// Throws InputError if these are several groups. The message says how to name one of them.
void refuse_several(const std::vector<const Group*>& groups, const std::string& name);

}  // namespace tetraction
