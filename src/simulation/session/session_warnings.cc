// The warnings of a session for its user, and the advice after a failure.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session_impl.h"
#include "simulation/facts/load_facts.h"
#include "tetraction/core/blas.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// Share of a step within which an event is due.
constexpr double kSameTime = 1e-6;
// Of the energy that entered.
constexpr double kLargeEnergyError = 0.1;

std::string no_such_event(const EventSettings& event, double end) {
  return fmt::format(
      "{} is at {} s, but no step starts then or later: the end is at {} s. It does not happen.",
      event.where, event.at, end);
}

// What midpoint's failures end with: a rule that goes on in the steps in which they happen.
std::string other_rule(Integrator rule, const MechanicalSystem& system) {
  if (rule != Integrator::kMidpoint) return {};
  return system.part() == nullptr ? ", or integrator = \"energy-momentum\", which keeps the energy "
                                    "also where steps do not resolve "
                                    "the motion, such as the spin of a stiff body"
                                  : ", or integrator = \"backward-euler\"";
}

}  // namespace

double resolved_frequency(Integrator integrator, double time_step) {
  return 1.0 / ((is_variational(integrator) ? 20.0 : 400.0) * time_step);
}

std::string Session::Impl::step_warning(const StabilityLimit& limit) const {
  if (is_implicit(settings.time.integrator) || progress.plan.time_step <= limit.critical_step)
    return {};
  std::string why;
  if (anywhere(system->part(), !system->constraints().springs().empty())) {
    why = " (the springs of fix.mode = \"penalty\" count: the stiffer, the lower the limit)";
  } else if (limit.damping_rate * progress.plan.time_step > 0.5) {
    why = " (the damping counts: the stronger, the lower the limit)";
  }
  return fmt::format(
      "the step {:.4g} s is above the stability limit h_crit = {:.4g} s of the {} rule{}: "
      "the run will blow up. Take a smaller time.step, \"auto\", or an implicit integrator.",
      progress.plan.time_step, limit.critical_step, to_string(settings.time.integrator), why);
}

// Settings stay as they are until an event changes them. They may be for a later event.
void Session::Impl::warn_of_unused_settings() {
  struct Given {
    TimeSettings time;
    std::string where;  // empty for the scene
  };
  std::vector<Given> all{{settings.time, ""}};
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change != nullptr) all.push_back({change->time, event.where + ": "});
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
      progress.warnings.push_back(
          given->where +
          "time.tolerance, time.min_step and time.max_step have no effect without time.adapt: all "
          "steps have the size time.step.");
    } else if (sets_tolerance && !uses_tolerance) {
      progress.warnings.push_back(
          given->where +
          "time.tolerance has no effect with time.adapt = \"energy\": the size of the first step, "
          "time.step, determines how exact the run is.");
    }
    before = time;
  }
}

void Session::Impl::warn_of_blas() {
  bool implicit = is_implicit(settings.time.integrator);
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      implicit = implicit || (change != nullptr && is_implicit(change->time.integrator));
    }
  }
  if (!implicit) return;
  if (std::string warning = blas_warning(); !warning.empty()) {
    progress.warnings.push_back(std::move(warning));
  }
}

void Session::Impl::warn_of_events() {
  // The time at which the step was set last. Events may change step and end.
  double start = state().time;
  double end = settings.time.end;
  double step = progress.plan.time_step;
  bool varies = settings.time.automatic || adapts();
  const auto steps_until = [&](double when) {
    return std::max(0.0, std::ceil((when - start) / step - kSameTime));
  };
  for (const EventSettings& event : scene.event) {
    // If steps change their size, the last one may begin at any time before the end.
    const double last_start =
        varies ? end - 2.0 * kSameTime * step : start + (steps_until(end) - 1.0) * step;
    if (event.at > last_start + kSameTime * step) {
      progress.warnings.push_back(no_such_event(event, end));
      continue;
    }
    if (event.at < 0.0) {
      progress.warnings.push_back(
          fmt::format("{} is at {} s, before the start: it happens before the first step.",
                      event.where, event.at));
    }
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change == nullptr) continue;
      start += steps_until(event.at) * step;
      if (change->time.end != end && change->time.end <= event.at) {
        progress.warnings.push_back(fmt::format(
            "{} sets time.end = {} s at {} s, when this time has passed: the run ends there.",
            event.where, change->time.end, event.at));
      }
      end = change->time.end;
      varies = change->time.automatic || change->time.adapt != StepAdaptation::kNone;
      if (!change->time.automatic) step = change->time.step;
    }
  }
}

void Session::Impl::warn_of_repeated_constraints() {
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
  if (repeated == 0) return;
  if (repeated > 1) example += fmt::format(", and {} more repeat another one", repeated - 1);
  progress.warnings.push_back(example + ": they are one constraint, whose tension they share.");
}

void Session::Impl::warn_of_loads() {
  const auto warn = [&](const ForceSettings& load, double start) {
    if (load.until > start) return;
    progress.warnings.push_back(
        fmt::format("{} ends at {} s, and {} {} s: it never acts.", load.where, load.until,
                    start > 0.0 ? "is added at" : "the run starts at", start));
  };
  for (const LoadKind kind : load_kinds()) {
    for (const ForceSettings& load : scene.list(kind)) {
      warn(load, 0.0);
      if (std::string warning = volume_group_warning(load, *system); !warning.empty()) {
        progress.warnings.push_back(std::move(warning));
      }
    }
  }
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* added = std::get_if<SetForce>(&edit);
      if (added != nullptr && !added->index) warn(added->force, std::max(0.0, event.at));
    }
  }
}

void Session::Impl::warn_of_inverted_corners() {
  const InvertedAtNodes inverted = inverted_at_nodes(system->rest(), state().position);
  if (inverted.count == 0) return;
  progress.warnings.push_back(
      fmt::format("at the end {} of the quadratic elements {} turned inside out (J < 0) at a node, "
                  "the first is "
                  "element {}. Materials see J at the points of quadrature only, where it is "
                  "positive. Stresses "
                  "around there are not reliable: take a finer mesh there.",
                  inverted.count, inverted.count == 1 ? "is" : "are", element_id(inverted.first)));
}

void Session::Impl::warn_at_the_end() {
  warn_of_inverted_corners();
  warn_of_step_control();
  if (is_automatic() || adapts()) {
    for (std::size_t i = progress.next_event; i < scene.event.size(); ++i) {
      std::string warning = no_such_event(scene.event[i], settings.time.end);
      if (std::find(progress.warnings.begin(), progress.warnings.end(), warning) ==
          progress.warnings.end()) {
        progress.warnings.push_back(std::move(warning));
      }
    }
  }
  if (const double over = balance->residual_over_tolerance(); over > 1.0) {
    progress.warnings.push_back(fmt::format(
        "round-off kept {} of the implicit steps from solver.tolerance = {:.3g}: they reached "
        "{:.2g}, which is what double precision leaves of the forces of this mesh. Thin or flat "
        "elements have large stiffnesses beside small loads: make them less so, or take a larger "
        "tolerance, which changes nothing but this warning.",
        balance->steps_limited_by_round_off(), settings.solver.tolerance,
        over * settings.solver.tolerance));
  }
  const double drift = balance->max_relative_energy_drift();
  if (!(drift > kLargeEnergyError)) return;
  // Where every vertex is held, the integrator solves for nothing that a smaller step could resolve.
  if (system->coordinates().count() == 0) return;
  const double frequency = resolved_frequency(settings.time.integrator, progress.plan.time_step);
  if (adapts()) {
    progress.warnings.push_back(fmt::format(
        "the energy error reached {:.3g} % of the energy that entered: the steps, down to {:.4g} "
        "s, "
        "do not resolve the motion. Take a smaller {}{}.",
        100.0 * drift, progress.steps.smallest,
        settings.time.adapt == StepAdaptation::kError ? "time.tolerance"
                                                      : "time.step, which is the first one",
        other_rule(settings.time.integrator, *system)));
    return;
  }
  if (is_automatic()) {
    progress.warnings.push_back(fmt::format(
        "the energy error reached {:.3g} % of the energy that entered: time.step = \"auto\" keeps "
        "steps stable, but they do not resolve the motion. Give time.step in seconds, below "
        "{:.4g} s.",
        100.0 * drift, progress.steps.smallest));
    return;
  }
  if (settings.time.integrator != Integrator::kBackwardEuler) {
    progress.warnings.push_back(fmt::format(
        "the energy error reached {:.3g} % of the energy that entered: the step does not resolve "
        "the "
        "motion. {:.4g} s resolve vibrations up to {:.3g} Hz (20 steps a period). Take a smaller "
        "time.step{}.",
        100.0 * drift, progress.plan.time_step, frequency,
        other_rule(settings.time.integrator, *system)));
    return;
  }
  progress.warnings.push_back(fmt::format(
      "the energy error reached {:.3g} % of the energy that entered: backward-euler damps what the "
      "step does not resolve, which is right on the way to rest and wrong for a motion. With "
      "{:.4g} s "
      "vibrations up to {:.3g} Hz keep nine tenths of their energy over a period. Take a smaller "
      "time.step, or midpoint.",
      100.0 * drift, progress.plan.time_step, frequency));
}

void Session::Impl::warn_of_materials() {
  for (const auto& warning_of : {locking_warning, thin_wall_warning, instability_warning}) {
    if (std::string warning = warning_of(*system); !warning.empty()) {
      progress.warnings.push_back(std::move(warning));
    }
  }
}

std::string Session::Impl::limit_advice() const {
  const double step = progress.plan.time_step;
  const double limit = present_limit();
  if (settings.time.adapt == StepAdaptation::kEnergy) {
    return fmt::format(
        "The step is {:.4g} s, as time.adapt = \"energy\" chose it. Take a smaller time.step or "
        "time.max_step, or time.adapt = \"error\"{}, and check the loads.",
        step, other_rule(settings.time.integrator, *system));
  }
  if (adapts()) {
    return fmt::format(
        "time.adapt made the steps smaller, down to {:.4g} s, which did not help. Check loads, "
        "materials and prescribed motion, or make time.min_step smaller{}.",
        step, other_rule(settings.time.integrator, *system));
  }
  if (settings.time.retry > 0) {
    return fmt::format(
        "The step of {:.4g} s was halved {} times (time.retry), which did not help. Take a smaller "
        "time.step or a larger time.retry{}, and check the loads.",
        step, settings.time.retry, other_rule(settings.time.integrator, *system));
  }
  if (is_automatic()) {
    return fmt::format(
        "The steps were half of the stability limit, which has come down to {:.4g} s (initially "
        "{:.4g} s). Check loads and prescribed motion, end the run earlier, or take an implicit "
        "integrator.",
        limit, initial_limit.critical_step);
  }
  if (!is_implicit(settings.time.integrator)) {
    return fmt::format(
        "The step is {:.4g} s; the stability limit is {:.4g} s (initially {:.4g} s). Take a step "
        "below it, time.step = \"auto\", or an implicit integrator.",
        step, limit, initial_limit.critical_step);
  }
  return fmt::format(
      "The step is {:.4g} s, {:.3g} times the explicit stability limit of {:.4g} s. Take a smaller "
      "time.step{}, and check the loads.",
      step, step / limit, limit,
      settings.time.integrator == Integrator::kEnergyMomentum
          ? " or backward-euler"
          : other_rule(settings.time.integrator, *system));
}

// A vertex near the centre of attraction is the likely cause of a failure.
std::string Session::Impl::center_note() {
  if (!system->environment().is_singular()) return {};
  Index nearest = 0;
  const double distance =
      state().position.reshaped(3, system->vertex_count()).colwise().norm().minCoeff(&nearest);
  const double moved = state().velocity.segment<3>(3 * nearest).norm() * progress.plan.time_step;
  // If a vertex passes the centre at a distance below its motion in one step, it gets an arbitrary
  // energy there. It may be far away when the effect becomes visible.
  if (distance <= 4.0 * moved || distance == 0.0) {
    progress.passed_center = fmt::format(
        "; vertex {} came as near as {:.3g} m to the centre of attraction, where the force has no "
        "bound: give environment.softening a length",
        system->mesh().vertex_id(nearest), distance);
  }
  return progress.passed_center;
}

}  // namespace tetraction
