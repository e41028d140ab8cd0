// The description of a mesh that `mesh info` and `check` print.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tetraction/io/mesh_quality.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The numbers of vertices and tetrahedra, and the volume, as in "8 vertices, 6 tetrahedra, volume 1 m3".
std::string size_text(const TetMesh& mesh);

/// Counts, volume, bounding box, groups, regions, and the quality, which mesh_quality() computes.
nlohmann::ordered_json mesh_json(const TetMesh& mesh, const std::vector<std::string>& unused,
                                 const std::vector<QualityMeasure>& quality);

/// The same as a table with a histogram, on stdout.
void print_mesh_table(const TetMesh& mesh, const std::vector<std::string>& unused,
                      const std::vector<QualityMeasure>& quality);

}  // namespace tetraction
