// The size of a session's steps, and one step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr double kMostSteps = 9e15;  // double precision represents all integers up to this one
// If the remaining time is shorter than this share of a step, the step before it is made longer.
constexpr double kMerged = 1e-6;
// "auto" gives up if its steps would be shorter than this share of the first ones.
constexpr double kShortest = 1e-6;

// What times near t are rounded to.
double round_off(double t) {
  return 4.0 * std::numeric_limits<double>::epsilon() * std::abs(t);
}

// Whether a smaller step may succeed where this one failed.
bool was_too_large(StepStatus status) {
  return status == StepStatus::kInverted || status == StepStatus::kNotFinite ||
         status == StepStatus::kOverdamped || status == StepStatus::kUndefined;
}

bool defined_inside_out(const MaterialModel& material) {
  const Matrix3 mirrored = Vector3(-1.0, 1.0, 1.0).asDiagonal();
  return std::visit([&](const auto& m) { return m.admissible(mirrored); }, material);
}

}  // namespace

Index Session::Impl::steps_to_end(double step) const {
  const double left = time.end - state.time;
  if (std::isfinite(time.end) && left <= round_off(time.end)) return 0;
  const double count = std::ceil(std::min(left / step, kMostSteps) - kMerged);
  return std::max<Index>(1, static_cast<Index>(count));
}

void Session::Impl::set_time_step(double step) {
  if (state.step > 0 && step != stepping.time_step) ++steps.changes;
  stepping.time_step = step;
  stepping.segment_time = state.time;
  stepping.segment_step = state.step;
  stepping.segment_count = steps_to_end(step);
}

bool Session::Impl::is_automatic() const {
  return time.automatic && !is_implicit(time.integrator);
}

void Session::Impl::choose_step(const StabilityLimit& limit, CriticalModes modes) {
  const double step = time.automatic ? AutomaticStep::kShare * limit.critical_step : time.step;
  if (!(step > 0.0) || !std::isfinite(step)) {
    throw InputError(
        "time.step = \"auto\" finds no stability limit for this body: give the step in seconds.");
  }
  const double left = time.end - state.time;
  if (std::isfinite(time.end) && left / step > kMostSteps) {
    throw InputError(
        fmt::format("The run has {:.3g} steps, more than can be counted: make time.step = {} s "
                    "larger or time.end = {} s earlier.",
                    left / step, step, time.end));
  }
  set_time_step(step);
  if (!time.automatic) return;
  stepping.automatic = AutomaticStep(limit.critical_step, std::move(modes), state.step);
  first_time_step = step;
  tracker.reset();
}

StabilityLimit Session::Impl::limit_at(const Vector& q, CriticalModes* modes) const {
  return stability_limit(*system, q, time.integrator, modes, state.time);
}

StabilityLimit Session::Impl::current_limit(const Vector& q, CriticalModes* modes) {
  const PhaseTimer timer(times.stability);
  return limit_at(q, modes);
}

// Called within a step, whose time must not be counted twice.
double Session::Impl::tracked_limit(double& cost) {
  const double before = times.stability;
  double critical = 0.0;
  {
    const PhaseTimer timer(times.stability);
    if (!tracker) tracker = std::make_unique<StabilityTracker>(*system);
    critical = tracker->critical_step(state.position, time.integrator, stepping.automatic.modes(),
                                      state.time);
    cost = tracker->cost();
  }
  times.stepping -= times.stability - before;
  return critical;
}

void Session::Impl::renew_automatic_step(const StabilityLimit& limit, CriticalModes modes) {
  if (!is_automatic() || !std::isfinite(limit.critical_step)) return;
  // The step stays as it is if it is hardly too large and not much too small.
  const double wanted = AutomaticStep::kShare * limit.critical_step;
  if (stepping.time_step > 1.001 * wanted || stepping.time_step < 0.8 * wanted) {
    set_time_step(wanted);
  }
  stepping.automatic = AutomaticStep(limit.critical_step, std::move(modes), state.step);
  first_time_step = stepping.time_step;
  tracker.reset();
}

bool Session::Impl::follow_limit() {
  if (!is_automatic() || !stepping.automatic.is_due(state.step)) return true;
  AutomaticStep& automatic = stepping.automatic;
  double cost = 0.0;
  const double critical = tracked_limit(cost);
  const double step = automatic.enter(critical, cost, state.step, stepping.time_step);
  if (!(step > kShortest * first_time_step)) {
    const Index element = critical_element(*system, automatic.modes());
    stop(RunStatus::kUnstable,
         fmt::format("stability would need steps of {:.3g} s, less than a millionth of the first "
                     "one: the body is crushed or torn",
                     step),
         element);
    return false;
  }
  if (step != stepping.time_step) set_time_step(step);
  return true;
}

StepOutcome Session::Impl::attempt() {
  const double h = stepping.time_step;
  const Index number = state.step - stepping.segment_step + 1;
  double length = h;
  // The time is a multiple of h, not a running sum, so that it has no accumulated round-off.
  double end_time = stepping.segment_time + static_cast<double>(number) * h;
  if (number == stepping.segment_count && std::isfinite(time.end)) {
    end_time = time.end;
    const double left = end_time - state.time;
    if (std::abs(left - h) > round_off(end_time)) length = left;
  }
  system->external_force(state.time, length, external_force);
  StepOutcome outcome = stepper->step_to(state, length, end_time);
  last_report = outcome.minimizer;
  total_iterations += outcome.minimizer.iterations;
  total_factorizations += outcome.minimizer.factorizations;
  total_cg_iterations += outcome.minimizer.cg_iterations;
  if (!outcome.minimizer.linear.empty()) linear_solver = outcome.minimizer.linear;
  if (outcome.ok() && is_automatic()) {
    // A step was too large if its energy error is larger than all the energy that has entered.
    const Balance before = *balance;
    balance->enter(state, outcome);
    const double made = balance->energy_error() - before.energy_error();
    if (relative_energy(made) > 1.0 && stepper->take_back(state)) {
      balance = std::make_unique<Balance>(before);
      outcome.status = StepStatus::kNotFinite;
      outcome.message = "the step makes more energy than ever entered";
    } else {
      stepping.automatic.watch(made, balance->energy_scale(), state.step);
      stepping.automatic.watch_elastic(outcome.elastic_energy, state.step);
    }
  } else if (outcome.ok()) {
    balance->enter(state, outcome);
  }
  if (outcome.ok()) {
    steps.last = length;
    steps.largest = std::max(steps.largest, length);
    const bool cut_short = length < h;
    if (!cut_short || steps.smallest == 0.0) {
      steps.smallest = steps.smallest == 0.0 ? length : std::min(steps.smallest, length);
    }
  }
  return outcome;
}

StepOutcome Session::Impl::advance() {
  StepOutcome outcome = attempt();
  if (!is_automatic() || !was_too_large(outcome.status)) return outcome;
  // The limit has decreased faster than the step followed it.
  constexpr int kHalvings = 20;
  const Stepping before = stepping;
  const Index changes = steps.changes;
  CriticalModes modes;
  const StabilityLimit limit = current_limit(state.position, &modes);
  double step = std::min(0.5 * stepping.time_step, AutomaticStep::kShare * limit.critical_step);
  for (int i = 0; i < kHalvings && step > kShortest * first_time_step; ++i, step *= 0.5) {
    set_time_step(step);
    stepping.automatic = AutomaticStep(limit.critical_step, modes, state.step);
    outcome = attempt();
    if (!was_too_large(outcome.status)) {
      steps.changes = changes + 1;
      return outcome;
    }
  }
  stepping = before;
  steps.changes = changes;
  return outcome;
}

void Session::Impl::count_inverted(const double* energy_after_step) {
  const ElasticPotential& elastic = system->elastic();
  if (energy_after_step == nullptr) {
    const auto& models = elastic.materials();
    inversion_counter.reset();
    if (std::any_of(models.begin(), models.end(), defined_inside_out)) {
      inversion_counter = std::make_unique<InversionCounter>(elastic);
    }
  }
  if (!inversion_counter) {
    inverted.now = 0;
    return;
  }
  inverted.now = energy_after_step != nullptr && inverted.now == 0 && !is_implicit(time.integrator)
                     ? inversion_counter->count_after_step(state.position, *energy_after_step)
                     : inversion_counter->count(state.position);
  if (inverted.now > inverted.most) {
    inverted.most = inverted.now;
    inverted.most_step = state.step;
  }
  if (inverted.now == 0 || inverted.first >= 0) return;
  inverted.first = element_id(inversion_counter->first(state.position));
  inverted.first_time = state.time;
  warnings.push_back(
      fmt::format("element {} is turned inside out (J < 0) at t = {:.6g} s, which its material "
                  "does not resist: "
                  "from there on the result is no deformation of a body. history.csv counts such "
                  "elements. Take "
                  "neo-hookean, a smaller time.step or a finer mesh, or check the loads.",
                  inverted.first, inverted.first_time));
}

bool Session::may_invert() const {
  const auto& models = impl_->system->elastic().materials();
  if (std::any_of(models.begin(), models.end(), defined_inside_out)) return true;
  for (const EventSettings& event : impl_->scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetMaterial>(&edit);
      if (change != nullptr && defined_inside_out(make_material(change->material))) return true;
    }
  }
  return false;
}

}  // namespace tetraction
