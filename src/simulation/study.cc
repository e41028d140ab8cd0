#include "tetraction/simulation/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "position_errors.h"
#include "probe_errors.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"

namespace tetraction {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// An error below this many times the reference's own error gives no order.
constexpr double kAboveReference = 5.0;

struct Run {
  StudyRow row;
  Vector final_position;
  double mean_distance = kNone;     // from the reference over time, m
  double probe_difference = kNone;  // the largest one over time
};

class Study {
 public:
  Study(const StudyPlan& plan, const TetMesh& mesh) : plan_(plan), mesh_(mesh) {
    result_.stable_step = plan.stable_step;
    result_.end = plan.end;
    result_.reference_integrator = plan.reference.integrator;
    result_.reference_step = plan.reference.step;
    result_.error_probe = plan.error_probe;
    result_.probes = plan.probes;
  }

  StudyResult run(const ObserverFactory& observers, const StudyProgress& progress,
                  const StudyMemory& memory) {
    std::size_t done = 0;
    const auto tell = [&](const PlannedRun& run) {
      if (progress) progress(done, plan_.run_count(), run);
      ++done;
    };
    const auto kept = [&](const PlannedRun& run) {
      return memory.kept ? memory.kept(run) : std::optional<StudyRow>();
    };
    const auto finish = [&](const Run& run) {
      if (memory.made && run.row.status != RunStatus::kCancelled) memory.made(run.row);
    };
    std::vector<std::optional<StudyRow>> known;
    bool all_known = true;
    for (const PlannedRun& planned : plan_.runs) {
      known.push_back(is_reference(planned) ? std::nullopt : kept(planned));
      all_known = all_known && (known.back() || is_reference(planned));
    }

    // The reference is made first, because the others are compared with it while they run.
    std::vector<double> steps;
    for (const PlannedRun& run : plan_.runs) steps.push_back(run.step);
    std::sort(steps.begin(), steps.end());
    steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
    ReferenceTrack track(comparison_times(steps, result_.end, 3 * mesh_.vertex_count()));
    ReferenceProbe probe(plan_.error_probe);
    Run reference;
    if (std::optional<StudyRow> row = all_known ? kept(plan_.reference) : std::nullopt) {
      reference.row = std::move(*row);
      ++done;
    } else {
      tell(plan_.reference);
      reference = run_one(plan_.reference, observers, {&track, &probe});
      reference.mean_distance = 0.0;
      reference.probe_difference = 0.0;
      if (plan_.reference_is_row) reference.row.role = StudyRole::kReference;
      set_errors(reference, reference, track, probe);
      finish(reference);
    }
    result_.reference_status = reference.row.status;
    result_.reference_directory = reference.row.directory;

    std::vector<Run> runs;
    bool is_cancelled = reference.row.status == RunStatus::kCancelled;
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) {
      const PlannedRun& planned = plan_.runs[i];
      if (is_reference(planned)) {
        runs.push_back(reference);
        continue;
      }
      if (known[i]) {
        runs.emplace_back();
        runs.back().row = std::move(*known[i]);
        ++done;
        continue;
      }
      if (is_cancelled) continue;
      tell(planned);
      DistanceFromReference distance(track);
      ProbeDifference difference(plan_.error_probe, probe);
      runs.push_back(run_one(planned, observers, {&distance, &difference}));
      Run& run = runs.back();
      run.mean_distance = distance.root_mean_square();
      run.probe_difference = difference.largest();
      if (planned.variant > 0) run.row.role = StudyRole::kVariant;
      set_errors(run, reference, track, probe);
      finish(run);
      is_cancelled = run.row.status == RunStatus::kCancelled;
    }
    result_.is_interrupted = is_cancelled;
    if (is_cancelled) {
      result_.remarks.emplace_back("the study was interrupted: the runs from there on are missing");
    } else if (reference.row.status != RunStatus::kFinished) {
      result_.remarks.push_back("the reference run did not reach the end (" +
                                reference.row.message + "): there are no errors");
    }
    set_orders(runs, reference);
    for (Run& run : runs) result_.rows.push_back(std::move(run.row));
    return std::move(result_);
  }

 private:
  Run run_one(const PlannedRun& planned, const ObserverFactory& make_observers,
              std::vector<Observer*> watching) const {
    const StudyVariant& variant = plan_.variants[planned.variant];
    Scene scene = variant.scene;
    scene.time.integrator = planned.integrator;
    scene.time.step = planned.step;
    scene.time.automatic = false;
    if (!planned.solver.empty() && planned.solver != scene.solver.kind) {
      scene.solver.kind = planned.solver;
      scene.solver.linear = LinearSolver::kAuto;  // another solver has other linear solvers
    }
    Run run;
    run.row.integrator = planned.integrator;
    run.row.step = planned.step;
    run.row.solver = planned.solver;
    run.row.compares_solver = planned.compares_solver;
    run.row.variant = variant.name;
    run.row.directory = planned.directory;
    run.row.position_error = run.row.position_error_rms = run.row.observed_order = kNone;

    run.row.date = utc_now();
    const Machine machine = this_machine();
    run.row.processor = machine.processor;
    run.row.cores = machine.cores;
    run.row.threads = thread_count();

    Session session(scene, mesh_);
    std::vector<std::unique_ptr<Observer>> observers;
    if (make_observers) observers = make_observers(run.row.directory);
    for (const auto& observer : observers) watching.push_back(observer.get());
    run.row.status = session.run(watching);
    run.row.stable_step = session.initial_limit().critical_step;
    run.row.message = session.message();
    run.row.steps = session.state().step;
    run.row.wall_seconds = session.times().stepping;
    const double simulated = session.state().time;
    run.row.seconds_per_simulated_second =
        simulated > 0.0 ? run.row.wall_seconds / simulated : kNone;
    run.row.iterations_per_step =
        run.row.steps > 0
            ? static_cast<double>(session.total_iterations()) / static_cast<double>(run.row.steps)
            : 0.0;
    const Balance& balance = session.balance();
    run.row.max_relative_energy_drift = balance.max_relative_energy_drift();
    run.row.linear_momentum_drift = balance.linear_momentum_drift();
    run.row.angular_momentum_drift = balance.angular_momentum_drift();
    run.row.angular_momentum_drift_allowed = balance.allowed_angular_momentum_drift();
    if (run.row.status == RunStatus::kFinished) run.final_position = session.state().position;
    return run;
  }

  // The error that orders are computed from.
  double error_of(const StudyRow& row) const {
    return result_.error_probe.empty() ? row.position_error : row.probe_error;
  }

  // Whether this run of the table is the reference itself.
  bool is_reference(const PlannedRun& planned) const {
    return plan_.reference_is_row && planned.directory == plan_.reference.directory &&
           planned.step == plan_.reference.step;
  }

  // Computes errors relative to the reference.
  static void set_errors(Run& run, const Run& reference, const ReferenceTrack& track,
                         const ReferenceProbe& probe) {
    if (reference.row.status != RunStatus::kFinished || run.row.status != RunStatus::kFinished) {
      return;
    }
    run.row.position_error =
        (run.final_position - reference.final_position).norm() / track.scale_at_end();
    run.row.position_error_rms = run.mean_distance / track.scale_over_time();
    if (probe.largest() > 0.0) run.row.probe_error = run.probe_difference / probe.largest();
  }

  // Computes orders between neighbouring steps.
  void set_orders(std::vector<Run>& runs, const Run& reference) {
    if (reference.row.status != RunStatus::kFinished) return;
    const double reference_error = error_of_reference(runs);
    result_.reference_error = reference_error > 0.0 ? reference_error : kNone;
    for (std::size_t i = 1; i < runs.size(); ++i) {
      const StudyRow& finer = runs[i - 1].row;
      StudyRow& row = runs[i].row;
      if (finer.integrator != row.integrator || finer.variant != row.variant ||
          row.variant != plan_.variants.front().name || row.compares_solver ||
          finer.role == StudyRole::kReference) {
        continue;  // the errors of another variant are not errors of the rule
      }
      const bool family = row.integrator == result_.reference_integrator;
      if (!family && error_of(finer) < kAboveReference * reference_error) continue;
      row.observed_order = observed_order(finer.step, error_of(finer), row.step, error_of(row),
                                          family ? result_.reference_step : 0.0);
    }
  }

  // The error of the reference itself is estimated from the finest other run of its family and the
  // rule's order p: e(h) = C (h^p − h_r^p), so that C h_r^p = e h_r^p/(h^p − h_r^p). It is zero if
  // there is no such run.
  double error_of_reference(const std::vector<Run>& runs) const {
    for (const Run& run : runs) {
      const StudyRow& row = run.row;
      if (row.integrator != result_.reference_integrator || !(error_of(row) > 0.0) ||
          row.step <= result_.reference_step || row.variant != plan_.variants.front().name) {
        continue;
      }
      const double ratio = std::pow(row.step / result_.reference_step, order(row.integrator));
      return error_of(row) / (ratio - 1.0);
    }
    return 0.0;
  }

  const StudyPlan& plan_;
  const TetMesh& mesh_;
  StudyResult result_;
};

}  // namespace

std::string to_string(StudyRole role) {
  switch (role) {
    case StudyRole::kReference:
      return "reference";
    case StudyRole::kVariant:
      return "variant";
    case StudyRole::kRun:
      break;
  }
  return "run";
}

double observed_order(double h1, double e1, double h2, double e2, double hr) {
  if (!(e1 > 0.0) || !(e2 > e1) || !(h2 > h1) || !(h1 > hr)) return kNone;
  if (hr == 0.0) return std::log(e2 / e1) / std::log(h2 / h1);
  const double target = std::log(e2 / e1);
  const auto ratio = [&](double p) {
    return std::log((std::pow(h2, p) - std::pow(hr, p)) / (std::pow(h1, p) - std::pow(hr, p)));
  };
  double low = 1e-3;
  double high = 12.0;
  if (ratio(low) > target || ratio(high) < target) return kNone;
  while (high - low > 1e-10) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) < target ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

StudyResult run_study(const StudyPlan& plan, const TetMesh& mesh, const ObserverFactory& observers,
                      const StudyProgress& progress, const StudyMemory& memory) {
  return Study(plan, mesh).run(observers, progress, memory);
}

StudyResult run_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings,
                      const ObserverFactory& observers, const StudyProgress& progress) {
  return run_study(plan_study(scene, mesh, settings), mesh, observers, progress);
}

}  // namespace tetraction
