// The error of the mesh, from a run of a study that is made on a finer one.
#include <memory>
#include <string_view>

#include "tetraction/core/error.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

constexpr std::string_view kFolder = "mesh-check-";

// Half the edges halve the stability limit of explicit rules; a little more is left for flat tetrahedra.
bool is_stable_on_finer_mesh(const PlannedRun& run, double stable_step) {
  return is_implicit(run.integrator) || run.step <= 0.45 * stable_step;
}

}  // namespace

StudyPlan mesh_check_plan(const StudyPlan& plan, const TetMesh& mesh) {
  StudyPlan finer = plan;
  finer.variants.resize(1);
  StudyVariant& variant = finer.variants.front();
  variant.mesh =
      std::make_shared<const TetMesh>(refined_mesh(variant.mesh != nullptr ? *variant.mesh : mesh));
  std::erase_if(finer.runs, [&](const PlannedRun& run) {
    return run.variant != 0 || run.role == StudyRole::kTrial || run.compares_solver ||
           !run.settings.empty() || !is_stable_on_finer_mesh(run, plan.stable_step);
  });
  if (finer.runs.empty()) {
    throw InputError(
        "--mesh-check: no run of this study can be made on a mesh with half the edges, where "
        "explicit "
        "integrators need about half the step: add an implicit integrator, or a step of at most "
        "0.45x.");
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
