#include "scene_source.h"

#include <fmt/format.h>

#include <filesystem>

#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

TetMesh load_mesh(const Scene& scene) {
  if (scene.mesh.generate) return generate_mesh(*scene.mesh.generate);
  std::error_code error;
  if (!std::filesystem::exists(scene.mesh.file, error) && !error) {
    throw FileError(scene.mesh.file +
                    ": no such file. Check mesh.file; it is relative to the scene's folder.");
  }
  return read_mesh(scene.mesh.file, scene.mesh.scale);
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
