#include "run_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/inverted_elements.h"
#include "simulation/facts/load_facts.h"
#include "simulation/facts/obstacle_checks.h"
#include "simulation/stepping/adaptations.h"
#include "tetraction/core/blas.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// Share of a step within which an event is due.
constexpr double kDue = 1e-6;
// A share of the energy that entered.
constexpr double kLargeEnergyError = 0.1;

std::string no_such_event(const EventSettings& event, double end) {
  return fmt::format(
      "{} is at {} s, but no step starts then or later: the end is at {} s. It does not happen.",
      event.where, event.at, end);
}

}  // namespace

double resolved_frequency(Integrator integrator, double time_step) {
  return 1.0 / ((is_variational(integrator) ? 20.0 : 400.0) * time_step);
}

std::string step_warning(const RunData& run, const StabilityLimit& limit) {
  const Integrator rule = run.settings.time.integrator;
  const double step = run.progress.plan.time_step;
  if (is_implicit(rule) || step <= limit.critical_step) return {};
  std::string why;
  if (anywhere(run.system->part(), !run.system->constraints().springs().empty())) {
    why = " (the springs of fix.mode = \"penalty\" count: the stiffer, the lower the limit)";
  } else if (limit.damping_rate * step > 0.5) {
    why = " (the damping counts: the stronger, the lower the limit)";
  }
  return fmt::format(
      "the step {:.4g} s is above the stability limit h_crit = {:.4g} s of the {} rule{}: the run "
      "will blow up. Take a smaller time.step, \"auto\", or an implicit integrator.",
      step, limit.critical_step, to_string(rule), why);
}

// Settings stay as they are until an event changes them. They may be for a later event.
void warn_of_unused_settings(RunData& run) {
  struct Given {
    TimeSettings time;
    std::string where;  // empty for the scene
  };
  std::vector<Given> all{{run.settings.time, ""}};
  for (const EventSettings& event : run.scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change != nullptr) all.push_back({change->settings, event.where + ": "});
    }
  }
  TimeSettings before;
  for (auto given = all.begin(); given != all.end(); ++given) {
    const TimeSettings& time = given->time;
    const auto is_later = [&](const auto& condition) {
      return std::any_of(given, all.end(), [&](const Given& g) { return condition(g.time.adapt); });
    };
    const bool adapts_later = is_later([](StepAdaptation a) { return a != StepAdaptation::kNone; });
    const bool uses_tolerance =
        is_later([](StepAdaptation a) { return a == StepAdaptation::kError; });
    const bool sets_tolerance = time.tolerance != before.tolerance;
    const bool sets_bounds = time.min_step != before.min_step || time.max_step != before.max_step;
    if (!adapts_later && (sets_tolerance || sets_bounds)) {
      run.progress.warnings.push_back(
          given->where +
          "time.tolerance, time.min_step and time.max_step have no effect without time.adapt: all "
          "steps have the size time.step.");
    } else if (sets_tolerance && !uses_tolerance) {
      run.progress.warnings.push_back(
          given->where +
          "time.tolerance has no effect with time.adapt = \"energy\": the size of the first step, "
          "time.step, determines how exact the run is.");
    }
    before = time;
  }
}

void warn_of_blas(RunData& run) {
  bool implicit = is_implicit(run.settings.time.integrator);
  for (const EventSettings& event : run.scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      implicit = implicit || (change != nullptr && is_implicit(change->settings.integrator));
    }
  }
  if (implicit) add_warning(run.progress, blas_warning());
}

void warn_of_events(RunData& run) {
  const TimeSettings& time = run.settings.time;
  std::vector<std::string>& warnings = run.progress.warnings;
  // The time at which the step was set last. Events may change step and end.
  double start = run.state().time;
  double end = time.end;
  double step = run.progress.plan.time_step;
  bool varies = time.automatic || adapts(time);
  const auto steps_until = [&](double when) {
    return std::max(0.0, std::ceil((when - start) / step - kDue));
  };
  for (const EventSettings& event : run.scene.event) {
    // If steps change their size, the last one may begin at any time before the end.
    const double last_start =
        varies ? end - 2.0 * kDue * step : start + (steps_until(end) - 1.0) * step;
    if (event.at > last_start + kDue * step) {
      warnings.push_back(no_such_event(event, end));
      continue;
    }
    if (event.at < 0.0) {
      warnings.push_back(
          fmt::format("{} is at {} s, before the start: it happens before the first step.",
                      event.where, event.at));
    }
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change == nullptr) continue;
      start += steps_until(event.at) * step;
      if (change->settings.end != end && change->settings.end <= event.at) {
        warnings.push_back(fmt::format(
            "{} sets time.end = {} s at {} s, when this time has passed: the run ends there.",
            event.where, change->settings.end, event.at));
      }
      end = change->settings.end;
      varies = change->settings.automatic || adapts(change->settings);
      if (!change->settings.automatic) step = change->settings.step;
    }
  }
}

std::string repeated_constraint_warning(const std::vector<SharedDistance>& shared) {
  std::vector<std::size_t> first(shared.size(), shared.size());  // by the number of the distance
  std::size_t repeated = 0;
  std::string example;
  for (std::size_t i = 0; i < shared.size(); ++i) {
    if (shared[i].count == 0) continue;
    std::size_t& owner = first[shared[i].number];
    if (owner == shared.size()) {
      owner = i;
      continue;
    }
    if (repeated++ == 0) {
      example = fmt::format("constraint.{} is the same distance as constraint.{}", i, owner);
    }
  }
  if (repeated == 0) return {};
  if (repeated > 1) example += fmt::format(", and {} more repeat another one", repeated - 1);
  return example + ": they are one constraint, whose tension they share.";
}

void warn_of_loads(RunData& run) {
  for (std::string& warning : obstacle_warnings(run.scene, *run.system)) {
    add_warning(run.progress, std::move(warning));
  }
  const auto warn = [&](const ForceSettings& load, double start) {
    if (load.until > start) return;
    run.progress.warnings.push_back(
        fmt::format("{} ends at {} s, and {} {} s: it never acts.", load.where, load.until,
                    start > 0.0 ? "is added at" : "the run starts at", start));
  };
  for (const LoadKind kind : values_of<LoadKind>()) {
    for (const ForceSettings& load : run.scene.list(kind)) {
      warn(load, 0.0);
      add_warning(run.progress, volume_group_warning(load, *run.system));
    }
  }
  for (const EventSettings& event : run.scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* added = std::get_if<SetForce>(&edit);
      if (added != nullptr && !added->index) warn(added->entry, std::max(0.0, event.at));
    }
  }
}

std::string inverted_corner_warning(const MechanicalSystem& system, const Vector& position) {
  const InvertedAtNodes inverted = inverted_at_nodes(system.rest(), position);
  if (inverted.count == 0) return {};
  return fmt::format(
      "at the end {} of the quadratic elements {} turned inside out (J < 0) at a node, the first "
      "is element {}. Materials see J at the points of quadrature only, where it is positive. "
      "Stresses around there are not reliable: take a finer mesh there.",
      inverted.count, inverted.count == 1 ? "is" : "are",
      system.mesh().tetrahedron_id(inverted.first));
}

void warn_at_the_end(RunData& run, const StepStrategy& strategy) {
  RunProgress& progress = run.progress;
  const TimeSettings& time = run.settings.time;
  const Balance& balance = *run.balance;
  const Index step = run.state().step;
  add_warning(progress, inverted_corner_warning(*run.system, run.state().position));
  add_warning(progress, retry_warning(progress, step));
  for (const Adaptation& kind : adaptations()) {
    add_warning(progress, kind.warning(progress.control, time, step));
  }
  if (is_automatic(time) || adapts(time)) {
    for (std::size_t i = progress.next_event; i < run.scene.event.size(); ++i) {
      std::string warning = no_such_event(run.scene.event[i], time.end);
      if (std::ranges::find(progress.warnings, warning) == progress.warnings.end()) {
        progress.warnings.push_back(std::move(warning));
      }
    }
  }
  if (const double over = balance.residual_over_tolerance(); over > 1.0) {
    progress.warnings.push_back(fmt::format(
        "round-off kept {} of the implicit steps from solver.tolerance = {:.3g}: they reached "
        "{:.2g}, which is what double precision leaves of the forces of this mesh. Thin or flat "
        "elements have large stiffnesses beside small loads: make them less so, or take a larger "
        "tolerance, which changes nothing but this warning.",
        balance.steps_limited_by_round_off(), run.settings.solver.tolerance,
        over * run.settings.solver.tolerance));
  }
  const double drift = balance.max_relative_energy_drift();
  if (!(drift > kLargeEnergyError)) return;
  // Where every vertex is held, the integrator solves for nothing that a smaller step could resolve.
  if (run.system->coordinates().count() == 0) return;
  add_warning(progress, strategy.energy_warning(drift));
}

void warn_of_materials(RunData& run) {
  for (const auto& warning_of : {locking_warning, thin_wall_warning, instability_warning}) {
    add_warning(run.progress, warning_of(*run.system));
  }
}

}  // namespace tetraction
