// The size of a session's steps, and one step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "session_impl.h"
#include "step_count.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// If the remaining time is shorter than this share of a step, the step before it is made longer.
constexpr double kMerged = 1e-6;
// With "auto" a step is repeated with a smaller size if the energy error changes in it by more than
// this share of the energy that entered. Steps of half the stability limit change it by less where
// a body of a few hundred elements or more swings: by 2 % with verlet, and by 17 % with explicit, whose
// order is one.
double largest_energy_share(Integrator rule) {
  return order(rule) == 2 ? 0.05 : 0.2;
}
// If smaller steps do not help, it is accepted up to this share.
constexpr double kMostEnergyShare = 1.0;
// The share falls if it is smaller than this many times the share of a step of twice the size.
constexpr double kFalling = 0.5;
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

bool is_defined_inside_out(const MaterialField& material) {
  // A law that depends on the place may be somewhere.
  const auto* custom = std::get_if<CustomMaterial>(&material.model());
  if (custom != nullptr && custom->has_places()) return true;
  const Matrix3 mirrored = Vector3(-1.0, 1.0, 1.0).asDiagonal();
  return std::visit([&](const auto& m) { return m.admissible(mirrored); }, material.model());
}
bool law_is_defined_inside_out(const MaterialSettings& material) {
  if (material.custom) return is_defined_inside_out(MaterialField(*material.custom));
  return std::ranges::any_of(material_choices(), [&](const MaterialChoice& choice) {
    return choice.name == material.model && choice.defined_for_any_jacobian;
  });
}

}  // namespace

Index Session::Impl::steps_to_end(double step) const {
  const double left = settings.time.end - state().time;
  if (std::isfinite(settings.time.end) && left <= round_off(settings.time.end)) return 0;
  const double count = std::ceil(std::min(left / step, kMostSteps) - kMerged);
  return std::max<Index>(1, static_cast<Index>(count));
}

void Session::Impl::set_time_step(double step) {
  if (state().step > 0 && step != progress.plan.time_step) ++progress.steps.changes;
  progress.plan.time_step = step;
  progress.plan.segment_time = state().time;
  progress.plan.segment_step = state().step;
  progress.plan.segment_count = steps_to_end(step);
}

bool Session::Impl::is_automatic() const {
  return settings.time.automatic && !adapts() && !is_implicit(settings.time.integrator);
}

void Session::Impl::choose_step(const StabilityLimit& limit, CriticalModes modes) {
  double step =
      settings.time.automatic ? AutomaticStep::kShare * automatic_limit(limit) : settings.time.step;
  if (adapts()) {
    if (settings.time.min_step) step = std::max(step, *settings.time.min_step);
    if (settings.time.max_step) step = std::min(step, *settings.time.max_step);
  }
  const double first = step;
  if (follows_limit() && adapts()) step = std::min(step, kStableShare * automatic_limit(limit));
  if (!(step > 0.0) || !std::isfinite(step)) {
    throw InputError(
        "time.step = \"auto\" finds no stability limit for this body: give the step in seconds.");
  }
  const double left = settings.time.end - state().time;
  if (std::isfinite(settings.time.end) && left / step > kMostSteps) {
    throw InputError(
        fmt::format("The run has {:.3g} steps, more than can be counted: make time.step = {} s "
                    "larger or time.end = {} s earlier.",
                    left / step, step, settings.time.end));
  }
  const double shortest = left > round_off(settings.time.end) ? std::min(left, step) : step;
  if (!std::isnormal(shortest * shortest) || !std::isnormal(1.0 / (shortest * shortest))) {
    throw InputError(
        fmt::format("A step of {:.3g} s cannot be computed: the square of its length, or one over "
                    "it, is out of "
                    "the range of double precision. Make {} {}.",
                    shortest, shortest < step ? "time.end" : "time.step",
                    shortest < 1.0 ? "larger" : "smaller"));
  }
  set_time_step(step);
  progress.first_time_step = first;
  if (!follows_limit()) return;
  automatic().start(automatic_limit(limit), std::move(modes), state().step);
  tracker.reset();
  warn_of_smaller_steps();
}

StabilityLimit Session::Impl::limit_at(const Vector& q, CriticalModes* modes) const {
  return stability_limit(*system, q, settings.time.integrator, modes, state().time);
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
    critical = tracker->critical_step(state().position, settings.time.integrator,
                                      automatic().modes(), state().time);
    cost = tracker->cost();
  }
  times.stepping -= times.stability - before;
  return std::min(critical, damping_limit());
}

// Damping of single vertices slows down the motion of the whole body at a rate c. A stable step may
// be too large for it: at hc = 1 the rule `explicit` stops the body within a step. The energy error
// does not tell, because what damping dissipates is booked exactly.
double Session::Impl::damping_limit() const {
  constexpr double kResolved = 0.1;  // hc of "auto"
  const double rate = vertex_damping_rate(*system, state().position, state().time);
  return rate > 0.0 ? kResolved / (AutomaticStep::kShare * rate)
                    : std::numeric_limits<double>::infinity();
}

double Session::Impl::automatic_limit(const StabilityLimit& limit) const {
  return std::min(limit.critical_step, damping_limit());
}

void Session::Impl::renew_automatic_step(const StabilityLimit& limit, CriticalModes modes) {
  if (!follows_limit()) return;
  const double critical = automatic_limit(limit);
  if (!std::isfinite(critical)) return;
  if (adapts()) {
    automatic().start(critical, std::move(modes), state().step);
    tracker.reset();
    warn_of_smaller_steps();
    return;
  }
  // The step stays as it is if it is hardly too large and not much too small.
  const double wanted = AutomaticStep::kShare * critical;
  if (progress.plan.time_step > 1.001 * wanted || progress.plan.time_step < 0.8 * wanted) {
    set_time_step(wanted);
  }
  automatic().start(critical, std::move(modes), state().step);
  progress.first_time_step = progress.plan.time_step;
  tracker.reset();
}

bool Session::Impl::follow_limit() {
  if (!follows_limit() || !automatic().is_due(state().step)) return true;
  double cost = 0.0;
  const double critical = tracked_limit(cost);
  const double step = automatic().enter(critical, cost, state().step, progress.plan.time_step);
  if (adapts()) {  // bounds_of_steps() uses the limit
    warn_of_smaller_steps();
    return true;
  }
  if (!(step > kShortest * progress.first_time_step)) {
    const Index element = critical_element(*system, automatic().modes());
    stop(RunStatus::kUnstable,
         fmt::format("stability would need steps of {:.3g} s, less than a millionth of the first "
                     "one: the body is crushed or torn",
                     step),
         element);
    return false;
  }
  if (step != progress.plan.time_step) set_time_step(step);
  return true;
}

void Session::Impl::count(const MinimizerReport& report) {
  progress.last_report = report;
  progress.total_iterations += report.iterations;
  progress.total_factorizations += report.factorizations;
  progress.total_cg_iterations += report.cg_iterations;
  if (!report.linear.empty()) progress.linear_solver = report.linear;
}

Session::Impl::Span Session::Impl::planned_span() const {
  const double h = progress.plan.time_step;
  const Index number = state().step - progress.plan.segment_step + 1;
  // The time is a multiple of h, not a running sum, so that it has no accumulated round-off.
  Span span{h, progress.plan.segment_time + static_cast<double>(number) * h};
  if (number == progress.plan.segment_count && std::isfinite(settings.time.end)) {
    span.end = settings.time.end;
    const double left = span.end - state().time;
    if (std::abs(left - h) > round_off(span.end)) span.length = left;
  }
  return span;
}

void Session::Impl::enter_length(double length, bool is_cut_short) {
  StepRange& steps = progress.steps;
  steps.last = length;
  steps.largest = std::max(steps.largest, length);
  if (!is_cut_short || steps.smallest == 0.0) {
    steps.smallest = steps.smallest == 0.0 ? length : std::min(steps.smallest, length);
  }
}

Session::Impl::Attempt Session::Impl::attempt(double most_energy_share) {
  const auto [length, end_time] = planned_span();
  system->applied_force(state().position, state().time, length, trial_external_force);
  StepOutcome outcome = stepper->advance(state(), states.other(), length, end_time);
  count(outcome.minimizer);
  if (!outcome.ok()) return {std::move(outcome)};
  double energy_share = 0.0;
  if (is_automatic()) {
    balance_before = balance->sums();
    const double error_before = balance->energy_error();
    balance->enter(states.other(), outcome);
    const double change = balance->energy_error() - error_before;
    energy_share = relative_energy(std::abs(change));
    if (!(energy_share <= most_energy_share)) {
      balance->restore(balance_before);
      stepper->reset();
      outcome.status = StepStatus::kNotFinite;
      outcome.message = fmt::format(
          "the integrator changes the energy by {:.3g} J, {:.3g} % of what "
          "entered, in one step",
          change, 100.0 * energy_share);
      return {std::move(outcome), energy_share};
    }
    automatic().watch(change, balance->energy_scale(), states.other().step);
    automatic().watch_elastic(outcome.elastic_energy, states.other().step);
  } else if (settings.time.retry > 0) {
    balance_before = balance->sums();
    const double error_before = balance->energy_error();
    balance->enter(states.other(), outcome);
    if (refuse_energy(outcome, error_before)) {
      balance->restore(balance_before);
      return {std::move(outcome)};
    }
  } else {
    balance_before = balance->sums();
    balance->enter(states.other(), outcome);
  }
  if (!std::isfinite(balance->energies().total())) {
    balance->restore(balance_before);
    stepper->reset();
    outcome.status = StepStatus::kNotFinite;
    return {std::move(outcome)};
  }
  accept_step();
  enter_length(length, length < progress.plan.time_step);
  return {std::move(outcome), energy_share};
}

StepOutcome Session::Impl::advance() {
  progress.control.last_rejected = 0;
  progress.control.last_substeps = 1;
  if (settings.time.adapt == StepAdaptation::kError) return advance_by_error();
  if (settings.time.adapt == StepAdaptation::kEnergy) return advance_by_energy();
  Attempt first = attempt(largest_energy_share(settings.time.integrator));
  if (settings.time.retry > 0 && !first.outcome.ok()) {
    return advance_in_halves(std::move(first.outcome));
  }
  if (!is_automatic() || !was_too_large(first.outcome.status)) return std::move(first.outcome);
  const StepPlan before = progress.plan;
  const Index changes = progress.steps.changes;
  const auto take_back_plan = [&] {
    progress.plan = before;
    progress.steps.changes = changes;
  };
  try {
    StepOutcome outcome = advance_in_smaller_steps(first);
    if (was_too_large(outcome.status)) take_back_plan();
    return outcome;
  } catch (...) {
    take_back_plan();
    throw;
  }
}

// The limit has decreased faster than the step followed it, or the step does not resolve the motion.
StepOutcome Session::Impl::advance_in_smaller_steps(const Attempt& first) {
  constexpr int kHalvings = 20;
  const Index changes = progress.steps.changes;
  const double step_before = progress.plan.time_step;
  CriticalModes modes;
  const double critical = automatic_limit(current_limit(state().position, &modes));
  double step = std::min(0.5 * progress.plan.time_step, AutomaticStep::kShare * critical);
  // The last attempt, the plan of the last one whose error fell, and how many came after that.
  Attempt last = first;
  StepPlan best = progress.plan;
  int unhelpful = 0;
  for (int i = 0; i < kHalvings && step > kShortest * progress.first_time_step; ++i, step *= 0.5) {
    if (cancelled_within_step()) return std::move(last.outcome);
    set_time_step(step);
    automatic().start(critical, modes, state().step);
    Attempt next = attempt(largest_energy_share(settings.time.integrator));
    if (!was_too_large(next.outcome.status)) {
      progress.steps.changes = changes + 1;
      return std::move(next.outcome);
    }
    // The error of a step that resolves the motion falls at least with the square of its size. An
    // error that does not fall is that of a sudden event, such as a support that begins to move.
    if (!(last.energy_share > 0.0) || next.energy_share < kFalling * last.energy_share) {
      best = progress.plan;
      unhelpful = 0;
    } else if (++unhelpful == 2) {
      progress.plan = best;
      progress.steps.changes = changes + (best.time_step == step_before ? 0 : 1);
      return attempt(kMostEnergyShare).outcome;
    }
    last = std::move(next);
  }
  return std::move(last.outcome);
}

std::unique_ptr<InversionCounter> Session::Impl::make_inversion_counter() const {
  const auto& models = system->elastic().materials();
  if (std::none_of(models.begin(), models.end(), is_defined_inside_out)) return nullptr;
  return std::make_unique<InversionCounter>(system->elastic());
}

void Session::Impl::count_inverted(const double* energy_after_step) {
  InvertedElements& inverted = progress.inverted;
  if (energy_after_step == nullptr) {
    inversion_counter = make_inversion_counter();
  }
  if (!inversion_counter) {
    inverted.now = 0;
    return;
  }
  const bool is_one_step = settings.time.adapt == StepAdaptation::kNone && settings.time.retry == 0;
  const bool is_small_step = energy_after_step != nullptr && inverted.now == 0 && is_one_step &&
                             !is_implicit(settings.time.integrator) && system->part() == nullptr;
  inverted.now = is_small_step ? inversion_counter->count_after_step(
                                     states.other().position, state().position, *energy_after_step)
                               : inversion_counter->count(state().position);
  const bool is_here = inverted.now > 0;
  inverted.now =
      static_cast<Index>(sum_over_parts(system->part(), static_cast<double>(inverted.now)));
  if (inverted.now > inverted.most) {
    inverted.most = inverted.now;
    inverted.most_step = state().step;
  }
  if (inverted.now == 0 || inverted.first >= 0) return;
  inverted.first = static_cast<std::int64_t>(least_of_parts(
      system->part(),
      is_here ? static_cast<double>(element_id(inversion_counter->first(state().position)))
              : std::numeric_limits<double>::infinity()));
  inverted.first_time = state().time;
  progress.warnings.push_back(
      fmt::format("element {} is turned inside out (J < 0) at t = {:.6g} s, which its material "
                  "does not resist: "
                  "from there on the result is no deformation of a body. history.csv counts such "
                  "elements. Take "
                  "neo-hookean, a smaller time.step or a finer mesh, or check the loads.",
                  inverted.first, inverted.first_time));
}

bool Session::may_invert() const {
  const auto& models = impl_->system->elastic().materials();
  if (std::any_of(models.begin(), models.end(), is_defined_inside_out)) return true;
  for (const EventSettings& event : impl_->scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetMaterial>(&edit);
      if (change != nullptr && law_is_defined_inside_out(change->material)) return true;
    }
  }
  return false;
}

}  // namespace tetraction
