// The error of the mesh, from a run of a study that is made on a finer one.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/simulation/quantities.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

constexpr std::string_view kFolder = "mesh-check-";

// Calls a function for each selection of a kind that is a part of another one.
template <class Kind, class Function>
void for_each_part(const Selection& selection, const Function& function) {
  if (const auto* found = std::get_if<Kind>(&selection)) function(*found);
  const std::vector<SelectionPart>* parts = nullptr;
  if (const auto* set = std::get_if<SelectSet>(&selection)) parts = &set->of;
  if (const auto* named = std::get_if<SelectNamed>(&selection)) parts = &named->of;
  if (parts == nullptr) return;
  for (const SelectionPart& part : *parts) for_each_part<Kind>(part.selection, function);
}

// Refuses what in a scene is another problem on the refined mesh: forces, momenta, springs and drag of every vertex of a
// selection whose number changes; selections by vertex numbers that leave out the new vertices between them; and nearest
// vertices that are others there. The error probe must keep its meaning, too.
class MeshDependence {
 public:
  MeshDependence(const TetMesh& coarse, const TetMesh& fine) : coarse_(coarse), fine_(fine) {}

  void check(const Scene& scene, const std::string& error_probe) const {
    check(scene.damping, "");
    check(scene.environment, "");
    check(scene.pull, "pull.vertices");
    for (const FixSettings& fix : scene.fix) check(fix, fix.where);
    for (const ConstraintSettings& constraint : scene.constraint) {
      check(constraint, constraint.where);
    }
    for (const ObstacleSettings& obstacle : scene.obstacle) {
      check(obstacle, obstacle.where);
    }
    for (const LoadKind kind : {LoadKind::kForce, LoadKind::kMoment, LoadKind::kTraction,
                                LoadKind::kPressure, LoadKind::kBodyForce}) {
      for (const ForceSettings& load : scene.list(kind)) check(load, load.where);
    }
    for (const MaterialRegionSettings& region : scene.material_region) {
      check_selection(region.select, region.where);
    }
    for (const MomentumSettings& momentum : scene.initial.momentum) check(momentum, momentum.where);
    for (const EventSettings& event : scene.event) {
      for (const Edit& edit : event.edits) {
        std::visit([&](const auto& change) { check_edit(change, event.where); }, edit);
      }
    }
    for (const ProbeSettings& probe : scene.probe) {
      if (probe.name == error_probe && !probe.point) check(probe);
    }
  }

 private:
  [[noreturn]] static void refuse(const std::string& where, const std::string& why) {
    throw InputError(fmt::format("--mesh-check: {}{}{}", where, where.empty() ? "" : ": ", why));
  }

  void check(const Damping& damping, const std::string& where) const {
    if (damping.drag == 0.0) return;
    refuse(where,
           "damping.drag acts on every vertex, so that a finer mesh has more of it. Take "
           "damping.mass_damping.");
  }
  void check(const EnvironmentSettings& environment, const std::string& where) const {
    if (environment.kind != EnvironmentKind::kAttraction || environment.strength == 0.0) return;
    refuse(where,
           "environment.kind = \"attraction\" pulls every vertex whatever its mass, so that a "
           "finer mesh is pulled more.");
  }
  void check(const PullSettings& pull, const std::string& where) const {
    if (pull.vertices.empty() ||
        !has_neighbours(select_vertices(coarse_, SelectVertices{pull.vertices}))) {
      return;
    }
    refuse(
        where,
        "the pulled vertices are selected by their numbers, which leave out those that the finer "
        "mesh has between them, and [pull] takes no other selection. Take a [[force]] on a face "
        "or an edge instead.");
  }
  void check(const FixSettings& fix, const std::string& where) const {
    check_selection(fix.select, where);
    if (fix.is_penalty) {
      check_count(fix.select, where,
                  "the springs of mode = \"penalty\" act on every selected vertex", "stiffness",
                  "Take mode = \"exact\".");
    }
  }
  void check(const ConstraintSettings& constraint, const std::string& where) const {
    if (has_selection(constraint.kind)) check_selection(constraint.select, where);
  }
  void check(const ObstacleSettings& obstacle, const std::string& where) const {
    check_selection(obstacle.select, where);
  }
  void check(const ForceSettings& load, const std::string& where) const {
    check_selection(load.select, where);
    if (load.kind == LoadKind::kForce && !load.total && load.vector != Vector3::Zero()) {
      check_count(load.select, where, "the force acts on every selected vertex", "force",
                  "Take total instead of vector.");
    }
  }
  void check(const MomentumSettings& momentum, const std::string& where) const {
    check_selection(momentum.select, where);
    check_count(momentum.select, where, "the momentum is that of every selected vertex", "momentum",
                "Take initial.velocity, or a force for a short time.");
  }
  void check(const ProbeSettings& probe) const {
    check_nearest(probe.select, probe.where);
    if (!quantity_of(probe.quantity).is_sum) return;
    const auto refuse_it = [&](const auto&) {
      refuse(probe.where, fmt::format("the {} of single vertices is that of a smaller part of the "
                                      "body on a finer mesh. Take another --error.",
                                      to_string(probe.quantity)));
    };
    for_each_part<SelectVertices>(probe.select, refuse_it);
    for_each_part<SelectNearest>(probe.select, refuse_it);
  }

  void check_edit(const SetDamping& edit, const std::string& where) const {
    check(edit.settings, where);
  }
  void check_edit(const SetEnvironment& edit, const std::string& where) const {
    check(edit.settings, where);
  }
  void check_edit(const SetPull& edit, const std::string& where) const {
    check(edit.settings, where);
  }
  template <class Entry>
  void check_edit(const SetEntry<Entry>& edit, const std::string& where) const {
    check(edit.entry, where);
  }
  void check_edit(const Unfix& edit, const std::string& where) const {
    check_selection(edit.select, where);
  }
  void check_edit(const SetMomentum& edit, const std::string& where) const {
    check(edit.change, where);
  }
  void check_edit(const ShiftState&, const std::string& where) const {
    refuse(where,
           "a shift moves single vertices, which are a smaller part of the body on a finer "
           "mesh.");
  }
  template <class Other>
  void check_edit(const Other&, const std::string&) const {}

  void check_selection(const Selection& selection, const std::string& where) const {
    check_nearest(selection, where);
    for_each_part<SelectVertices>(selection, [&](const SelectVertices& numbers) {
      if (!has_neighbours(select_vertices(coarse_, numbers))) return;
      refuse(where,
             "vertices are selected by their numbers, which leave out those that the finer mesh "
             "has between them. Select a face or an edge by a plane, a box or a group.");
    });
  }

  void check_nearest(const Selection& selection, const std::string& where) const {
    for_each_part<SelectNearest>(selection, [&](const SelectNearest& nearest) {
      if (select_vertices(coarse_, nearest) == select_vertices(fine_, nearest)) return;
      refuse(where,
             "another vertex is nearest to the point on the finer mesh. Take a point where "
             "the mesh has a vertex.");
    });
  }

  void check_count(const Selection& selection, const std::string& where, const char* what,
                   const char* sum, const char* remedy) const {
    const std::size_t coarse = select_vertices(coarse_, selection).size();
    const std::size_t fine = select_vertices(fine_, selection).size();
    if (coarse == fine) return;
    refuse(where, fmt::format("{}, and the finer mesh has {} of them instead of {}, so that the "
                              "whole {} is another one. {}",
                              what, fine, coarse, sum, remedy));
  }

  // Whether two of the vertices belong to the same tetrahedron.
  bool has_neighbours(const std::vector<Index>& vertices) const {
    std::vector<bool> is_selected(coarse_.vertices.size());
    for (const Index v : vertices) is_selected[static_cast<std::size_t>(v)] = true;
    const auto count = [&](const auto& corners) {
      return std::count_if(corners.begin(), corners.end(),
                           [&](Index v) { return is_selected[static_cast<std::size_t>(v)]; });
    };
    for (std::size_t e = 0; e < coarse_.tetrahedra.size(); ++e) {
      const auto middles = coarse_.is_quadratic() ? count(coarse_.edge_vertices[e]) : 0;
      if (count(coarse_.tetrahedra[e]) + middles > 1) return true;
    }
    return false;
  }

  const TetMesh& coarse_;
  const TetMesh& fine_;
};

// Half the edges halve the stability limit of explicit rules; a little more is left for flat tetrahedra.
bool is_stable_on_finer_mesh(const PlannedRun& run, double stable_step) {
  return is_implicit(run.integrator) || run.step <= 0.45 * stable_step;
}

}  // namespace

TetMesh mesh_of_mesh_check(const StudyPlan& plan, const TetMesh& mesh) {
  const StudyVariant& variant = plan.variants.front();
  const TetMesh& coarse = variant.mesh != nullptr ? *variant.mesh : mesh;
  TetMesh fine = refined_mesh(coarse);
  MeshDependence(coarse, fine).check(variant.scene, plan.error_probe);
  return fine;
}

StudyPlan mesh_check_plan(const StudyPlan& plan, std::shared_ptr<const TetMesh> fine) {
  StudyPlan finer = plan;
  finer.variants.resize(1);
  finer.variants.front().mesh = std::move(fine);
  std::erase_if(finer.runs, [&](const PlannedRun& run) {
    return run.variant != 0 || run.role == StudyRole::kTrial || run.compares_solver ||
           !run.settings.empty() || !is_stable_on_finer_mesh(run, plan.stable_step);
  });
  if (finer.runs.empty()) {
    throw InputError(
        "--mesh-check: no run of this study can be made on a mesh with half the edges, where "
        "explicit integrators need about half the step: add an implicit integrator, or a step of "
        "at most 0.45x.");
  }
  for (PlannedRun& run : finer.runs) {
    run.directory.insert(0, kFolder);
    run.role = StudyRole::kReference;
  }
  finer.references.clear();
  finer.reference_of.clear();
  finer.has_first_mesh.clear();
  return finer;
}

std::string coarse_run_of(const PlannedRun& run) {
  return run.directory.substr(kFolder.size());
}

const PlannedRun* run_of_mesh_check(const StudyPlan& finer, const StudyResult& result) {
  constexpr double kSmall = 0.01;
  const PlannedRun* best = nullptr;
  double best_error = 0.0;
  for (const PlannedRun& run : finer.runs) {
    for (const StudyRow& row : result.rows) {
      if (row.directory != coarse_run_of(run)) continue;
      const double error = row.is_reference             ? 0.0
                           : result.error_probe.empty() ? row.position_error
                                                        : row.probe_error;
      if (row.status != RunStatus::kFinished || !(error >= 0.0)) continue;
      const bool is_better =
          best == nullptr ||
          (error <= kSmall && best_error <= kSmall ? run.step > best->step : error < best_error);
      if (!is_better) continue;
      best = &run;
      best_error = error;
    }
  }
  return best;
}

double mesh_difference(const StudyPlan& plan, const MotionTrack& coarse, const MotionTrack& fine) {
  // The vertices of the coarse mesh are the first ones of the fine mesh.
  MotionTrack shared = fine;
  const Index size = coarse.rest.size();
  shared.rest = Vector(fine.rest.head(size));
  for (Vector& positions : shared.positions) positions = Vector(positions.head(size));
  return relative_error(
      coarse, shared,
      plan.error_probe.empty() ? ErrorMeasure{} : ErrorMeasure{plan.error_kind, plan.error_probe});
}

}  // namespace tetraction
