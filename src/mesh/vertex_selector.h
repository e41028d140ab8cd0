// The vertices of selections that do not consist of other selections.
#pragma once

#include <array>
#include <vector>

#include "tetraction/mesh/selection.h"

namespace tetraction {

using Triangle = std::array<Index, 3>;

/// The triangles of the boundary that face in the direction of the selection. Throws InputError for a normal or
/// an angle out of range.
std::vector<Triangle> facing(const TetMesh& mesh, const SelectFaces& s);

/// The vertices of a selection that is neither a set nor a named one, with repeats. Throws InputError for one that
/// does not go with the mesh. Collective for a mesh in parts.
std::vector<Index> selected_by(const TetMesh& mesh, const Selection& selection);

}  // namespace tetraction
