// The description of a mesh that `mesh info` and `check` print.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The numbers of vertices and tetrahedra, and the volume, as in "8 vertices, 6 tetrahedra, volume 1 m3".
std::string size_text(const TetMesh& mesh);

/// Counts, volume, bounding box, groups, regions, quality.
nlohmann::ordered_json mesh_json(const TetMesh& mesh, const std::vector<std::string>& unused);

/// The same as a table with a histogram, on stdout.
void print_mesh_table(const TetMesh& mesh, const std::vector<std::string>& unused);

}  // namespace tetraction
