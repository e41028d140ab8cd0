#include "scene_source.h"

#include <fmt/format.h>

#include "tetraction/io/initial_fields.h"

namespace tetraction {

TetMesh load_mesh(const Scene& scene) {
  return read_scene_mesh(scene);
}

std::string mesh_remarks(const TetMesh& mesh) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  const MeshReport& report = mesh.report;
  if (report.reoriented > 0) {
    add(fmt::format("{} inverted tetrahedra were reoriented", report.reoriented));
  }
  if (report.dropped_vertices > 0) {
    add(fmt::format("{} vertices that no tetrahedron uses were dropped", report.dropped_vertices));
  }
  for (const auto& [type, count] : report.skipped_cells) {
    add(fmt::format("{} cells of type {} were left out", count, to_string(type)));
  }
  return text.empty() ? text : mesh.source + ": " + text;
}

}  // namespace tetraction
