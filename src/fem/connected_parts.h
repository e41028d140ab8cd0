// The parts of a body that hang together.
#pragma once

#include <vector>

#include "mesh/mesh_pieces.h"
#include "tetraction/fem/free_coordinates.h"
#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// The vertices of each part that hangs together through elements, ascending, and through `sets`: all
/// vertices of a set belong to the same part.
std::vector<std::vector<Index>> connected_parts(const RestState& rest,
                                                const std::vector<AffineSet>& sets = {});

/// The pieces that hang together through faces, for each of these parts of the mesh.
std::vector<std::vector<MeshPiece>> pieces_of_parts(const TetMesh& mesh,
                                                    const std::vector<std::vector<Index>>& parts);

}  // namespace tetraction
