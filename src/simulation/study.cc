#include "tetraction/simulation/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "position_errors.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// An error less than this many times the reference's own says nothing of an order.
constexpr double kAboveReference = 5.0;

struct Run {
  StudyRow row;
  Vector final_position;
  double mean_distance = kNone;  // from the reference over time, m
};

// The step nearest to h that divides `end`: for steps that nobody asked for.
double dividing_step(double h, double end) {
  return end / std::max(1.0, std::round(end / h));
}

class Study {
 public:
  Study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings)
      : mesh_(mesh), settings_(settings), variants_(settings.variants) {
    if (variants_.empty()) variants_.push_back({"", scene});
  }

  StudyResult run(const ObserverFactory& observers, const StudyProgress& progress) {
    prepare();
    const std::vector<Integrator> integrators = integrators_of_study();
    const bool reference_is_row =
        std::count(integrators.begin(), integrators.end(), settings_.reference_integrator) > 0 &&
        std::count(steps_.begin(), steps_.end(), result_.reference_step) > 0;
    const std::size_t count = variants_.size() * integrators.size() * steps_.size() +
                              (reference_is_row ? std::size_t{0} : std::size_t{1});

    std::size_t done = 0;
    const auto tell = [&](Integrator integrator, double step) {
      if (progress) progress(done, count, integrator, step);
      ++done;
    };

    // The reference first: the others are compared with it while they run.
    ReferenceTrack track(comparison_times(steps_, result_.end, 3 * mesh_.vertex_count()));
    tell(settings_.reference_integrator, result_.reference_step);
    const Run reference =
        run_one(variants_.front(), settings_.reference_integrator, result_.reference_step,
                reference_is_row ? "" : "reference-", observers, track);
    result_.reference_status = reference.row.status;
    result_.reference_directory = reference.row.directory;

    std::vector<Run> runs;
    bool is_cancelled = reference.row.status == RunStatus::kCancelled;
    for (const StudyVariant& variant : variants_) {
      for (const Integrator integrator : integrators) {
        for (const double step : steps_) {
          if (is_the_reference(variant.name, integrator, step)) {
            runs.push_back(reference);
            runs.back().mean_distance = 0.0;
            runs.back().row.role = StudyRole::kReference;
            continue;
          }
          if (is_cancelled) continue;
          tell(integrator, step);
          DistanceFromReference distance(track);
          runs.push_back(run_one(variant, integrator, step, "", observers, distance));
          runs.back().mean_distance = distance.root_mean_square();
          StudyRow& row = runs.back().row;
          if (&variant != &variants_.front()) row.role = StudyRole::kVariant;
          is_cancelled = row.status == RunStatus::kCancelled;
        }
      }
    }
    if (is_cancelled) return cancelled(std::move(runs));
    if (reference.row.status != RunStatus::kFinished) {
      result_.remarks.push_back("the reference run did not reach the end (" +
                                reference.row.message + "): there are no position errors");
    }
    compare(runs, reference, track);
    for (Run& run : runs) result_.rows.push_back(std::move(run.row));
    return std::move(result_);
  }

 private:
  // What was computed up to then is kept, without errors.
  StudyResult cancelled(std::vector<Run> runs) {
    result_.remarks.emplace_back("the study was interrupted: the runs from there on are missing");
    result_.reference_status = RunStatus::kCancelled;
    for (Run& run : runs) result_.rows.push_back(std::move(run.row));
    return std::move(result_);
  }

  std::vector<Integrator> integrators_of_study() const {
    if (!settings_.integrators.empty()) return settings_.integrators;
    return {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
            Integrator::kBackwardEuler};
  }

  void prepare() {
    const Scene& scene = variants_.front().scene;
    result_.end = scene.time.end;
    for (const StudyVariant& variant : variants_) {
      if (variant.scene.time.end == result_.end) continue;
      throw InputError(
          fmt::format("The variants {} and {} end at different times, {} s and {} s: give all the "
                      "same time.end, or their positions cannot be compared.",
                      variants_.front().name, variant.name, result_.end, variant.scene.time.end));
    }
    result_.reference_integrator = settings_.reference_integrator;
    {
      const std::unique_ptr<MechanicalSystem> system = make_system(scene, mesh_);
      const State initial = make_initial_state(scene, *system);
      result_.stable_step = stability_limit(*system, initial.position).critical_step;
    }
    for (const EventSettings& event : scene.event) {
      for (const Edit& edit : event.edits) {
        if (!std::holds_alternative<SetTime>(edit)) continue;
        throw InputError(event.where +
                         " changes [time], which a study does itself: integrators and steps are "
                         "what it compares. Leave that change out.");
      }
    }
    std::vector<double> wanted = settings_.steps;
    if (wanted.empty()) {
      for (const double factor : {0.25, 0.5, 2.0, 8.0, 32.0}) {
        const double step = factor * result_.stable_step;
        if (step <= result_.end) wanted.push_back(dividing_step(step, result_.end));
      }
    }
    steps_.reserve(wanted.size());
    for (const double step : wanted) steps_.push_back(checked(step));
    if (steps_.empty()) {
      throw InputError("The end time is shorter than the stable step: make time.end larger.");
    }
    std::sort(steps_.begin(), steps_.end());
    steps_.erase(std::unique(steps_.begin(), steps_.end()), steps_.end());
    result_.reference_step =
        settings_.reference_step ? checked(*settings_.reference_step) : steps_.front();
  }

  double checked(double step) const {
    if (!(step > 0.0) || !std::isfinite(step) || step > result_.end) {
      throw InputError(
          fmt::format("A study's step must be positive and at most the end time {} s, not {} s.",
                      result_.end, step));
    }
    return step;
  }

  bool is_the_reference(const std::string& variant, Integrator integrator, double step) const {
    return variant == variants_.front().name && integrator == settings_.reference_integrator &&
           step == result_.reference_step;
  }

  Run run_one(const StudyVariant& variant, Integrator integrator, double step,
              const std::string& prefix, const ObserverFactory& make_observers,
              Observer& comparison) const {
    Scene scene = variant.scene;
    scene.time.integrator = integrator;
    scene.time.step = step;
    scene.time.automatic = false;
    Run run;
    run.row.integrator = integrator;
    run.row.step = step;
    run.row.variant = variant.name;
    run.row.directory = fmt::format("{}{}{}{}-{:.10g}", prefix, variant.name,
                                    variant.name.empty() ? "" : "-", to_string(integrator), step);
    run.row.position_error = run.row.position_error_rms = run.row.observed_order = kNone;

    Session session(scene, mesh_);
    std::vector<std::unique_ptr<Observer>> observers;
    if (make_observers) observers = make_observers(run.row.directory);
    std::vector<Observer*> watching;
    watching.reserve(observers.size() + 1);
    watching.push_back(&comparison);
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
    const Books& books = session.books();
    run.row.max_relative_energy_drift = books.max_relative_energy_drift();
    run.row.linear_momentum_drift = books.linear_momentum_drift();
    run.row.angular_momentum_drift = books.angular_momentum_drift();
    run.row.angular_momentum_drift_allowed = books.allowed_angular_momentum_drift();
    if (run.row.status == RunStatus::kFinished) run.final_position = session.state().position;
    return run;
  }

  // Errors against the reference, and orders between neighbouring steps.
  void compare(std::vector<Run>& runs, const Run& reference, const ReferenceTrack& track) const {
    if (reference.row.status != RunStatus::kFinished) return;
    for (Run& run : runs) {
      if (run.row.status != RunStatus::kFinished) continue;
      run.row.position_error =
          (run.final_position - reference.final_position).norm() / track.scale_at_end();
      run.row.position_error_rms = run.mean_distance / track.scale_over_time();
    }
    const double reference_error = error_of_reference(runs);
    for (std::size_t i = 1; i < runs.size(); ++i) {
      const StudyRow& finer = runs[i - 1].row;
      StudyRow& row = runs[i].row;
      if (finer.integrator != row.integrator || finer.variant != row.variant ||
          row.variant != variants_.front().name || finer.role == StudyRole::kReference) {
        continue;  // the errors of another variant are not errors of the rule
      }
      const bool family = row.integrator == result_.reference_integrator;
      if (!family && finer.position_error < kAboveReference * reference_error) continue;
      row.observed_order =
          observed_order(finer.step, finer.position_error, row.step, row.position_error,
                         family ? result_.reference_step : 0.0);
    }
  }

  // What the reference itself is off by, from the finest other run of its family and the rule's
  // order p: e(h) = C (h^p − h_r^p), so that C h_r^p = e h_r^p/(h^p − h_r^p). Zero if there is
  // none.
  double error_of_reference(const std::vector<Run>& runs) const {
    for (const Run& run : runs) {
      const StudyRow& row = run.row;
      if (row.integrator != result_.reference_integrator || !(row.position_error > 0.0) ||
          row.step <= result_.reference_step || row.variant != variants_.front().name) {
        continue;
      }
      const double ratio = std::pow(row.step / result_.reference_step, order(row.integrator));
      return row.position_error / (ratio - 1.0);
    }
    return 0.0;
  }

  const TetMesh& mesh_;
  const StudySettings& settings_;
  std::vector<StudyVariant> variants_;
  StudyResult result_;
  std::vector<double> steps_;
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

StudyResult run_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings,
                      const ObserverFactory& observers, const StudyProgress& progress) {
  return Study(scene, mesh, settings).run(observers, progress);
}

}  // namespace tetraction
