#include "limit_estimates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "automatic_step.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Damping of all vertices slows down the motion of the whole body at a rate c. A stable step may
// be too large for it: at hc = 1 the rule `explicit` stops the body within a step. The energy error
// does not tell, because what damping dissipates is booked exactly. A pull is left out, since it slows down the
// pulled vertices alone.
double damping_limit(const RunData& run) {
  constexpr double kResolved = 0.1;  // hc of "auto"
  const double rate = vertex_damping_rate(*run.system, run.state().position, run.state().time);
  return rate > 0.0 ? kResolved / (AutomaticStep::kShare * rate)
                    : std::numeric_limits<double>::infinity();
}

}  // namespace

StabilityLimit limit_at(const RunData& run, const Vector& q, CriticalModes* modes) {
  return stability_limit(*run.system, q, run.settings.time.integrator, modes, run.state().time);
}

StabilityLimit timed_limit(RunData& run, const Vector& q, CriticalModes* modes) {
  const PhaseTimer timer(run.times.stability);
  return limit_at(run, q, modes);
}

double present_limit(const RunData& run) {
  const MechanicalSystem& system = *run.system;
  double limit = run.initial_limit.critical_step;
  if (everywhere(system.part(), system.elastic().admissible(run.state().position).ok())) {
    limit = std::min(limit, limit_at(run, run.state().position).critical_step);
  }
  return limit;
}

double automatic_limit(const RunData& run, const StabilityLimit& limit) {
  return std::min(limit.critical_step, damping_limit(run));
}

double limit_beside_obstacles(RunData& run, double critical_step, double step) {
  const MechanicalSystem& system = *run.system;
  ImpactMemory& memory = run.memory.impact;
  const State& state = run.state();
  if (system.contact() == nullptr || !std::isfinite(critical_step)) return critical_step;
  if (state.time + step < memory.clear_until) return critical_step;
  if (memory.impedance == 0.0) memory.impedance = largest_impedance(system);
  Vector velocity;
  system.velocity_of(state.momentum, velocity);
  const Contact::ImpactForecast forecast =
      system.contact()->impact_forecast(system.force_point(state.position, state.time), velocity,
                                        memory.impedance, critical_step, step);
  memory.clear_until = state.time + forecast.valid_for;
  return forecast.limit;
}

void start_to_follow(RunData& run, double critical_step, CriticalModes modes) {
  AutomaticStep(run.progress.plan.automatic)
      .start(critical_step, std::move(modes), run.state().step);
  run.memory.tracker.reset();
  run.memory.impact = {};
}

// Called within a step, whose time must not be counted twice.
double enter_estimate(RunData& run) {
  AutomaticStep automatic(run.progress.plan.automatic);
  const double before = run.times.stability;
  double critical = 0.0;
  double cost = 0.0;
  {
    const PhaseTimer timer(run.times.stability);
    std::unique_ptr<StabilityTracker>& tracker = run.memory.tracker;
    if (!tracker) tracker = std::make_unique<StabilityTracker>(*run.system);
    critical = tracker->critical_step(run.state().position, run.settings.time.integrator,
                                      automatic.modes(), run.state().time);
    cost = tracker->cost();
  }
  run.times.stepping -= run.times.stability - before;
  return automatic.enter(std::min(critical, damping_limit(run)), cost, run.state().step,
                         run.progress.plan.time_step);
}

}  // namespace tetraction
