#include "scene_source.h"

#include <fmt/format.h>

#include <cmath>

#include "tetraction/mesh/mesh_checks.h"

namespace tetraction {

std::string mesh_remarks(const TetMesh& mesh, const std::vector<std::string>& unused) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  const MeshReport& report = mesh.report;
  if (report.reoriented > 0) {
    add(fmt::format("{} inverted tetrahedra were reoriented", report.reoriented));
  }
  if (report.dropped_vertices > 0) {
    add(fmt::format("{} vertices that no tetrahedron uses were dropped", report.dropped_vertices));
  }
  if (const Index count = coincident_vertices(mesh); count > 0) {
    add(
        fmt::format("{} vertices are at the place of another one: parts that touch only there do "
                    "not hang together",
                    count));
  }
  for (const auto& [type, count] : report.skipped_cells) {
    if (type == CellType::kTetrahedron) {
      add(fmt::format("{} tetrahedra with the vertices of an earlier one were left out", count));
      continue;
    }
    add(fmt::format("{} cells of type {} were left out", count, to_string(type)));
  }
  for (const std::string& part : unused) add("not used: " + part);
  return text.empty() ? text : mesh.source + ": " + text;
}

std::string damping_of_limit(const StabilityLimit& limit) {
  const double undamped = 2.0 / limit.omega_max;
  // Lanczos iterations find omega_max to 1e-4.
  if (!std::isfinite(undamped) || !(limit.critical_step < 0.999 * undamped)) return {};
  return fmt::format(
      "; the damping lowers it: without damping it would be 2/omega_max = {:.6g} s, and the "
      "largest damping rate is {:.6g} 1/s",
      undamped, limit.damping_rate);
}

std::string damping_remarks(const Scene& scene) {
  if (!scene.damping_ratio) return {};
  const auto& frequency = scene.damping_ratio->frequency;
  const LameParameters lame = initial_lame(make_material(scene.material));  // no array gives it
  std::string text = fmt::format(
      "damping.ratio gives mass_damping = {:.6g} 1/s and viscosity = {:.6g} Pa s. Damping ratios "
      "at {:.6g} and {:.6g} Hz:",
      scene.damping.mass_damping, scene.damping.viscosity, frequency[0], frequency[1]);
  const char* separator = " ";
  for (const DeformationKind kind :
       {DeformationKind::kShear, DeformationKind::kBending, DeformationKind::kVolumeChange}) {
    text += fmt::format("{}{} {:.4g} and {:.4g}", separator, to_string(kind),
                        damping_ratio(kind, scene.damping, lame, frequency[0]),
                        damping_ratio(kind, scene.damping, lame, frequency[1]));
    separator = "; ";
  }
  return text;
}

}  // namespace tetraction
