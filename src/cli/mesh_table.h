// The description of a mesh that `mesh info` and `check` print.
#pragma once

#include <nlohmann/json.hpp>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Counts, volume, bounding box, groups, regions, quality.
nlohmann::ordered_json mesh_json(const TetMesh& mesh);

/// The same as a table with a histogram, on stdout.
void print_mesh_table(const TetMesh& mesh);

}  // namespace tetraction
