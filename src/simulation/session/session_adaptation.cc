// Steps that are repeated in smaller ones (time.retry) and steps whose size adapts (time.adapt).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "mesh/bounding_box.h"
#include "session_impl.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

// If less than this share of a step is left to a landing, the step is made a little longer.
constexpr double kMerged = 1e-6;
// The discrete energy is kept to this share of the solver's tolerance, relative to the energy that
// entered, but not to less than what the solver's round-off makes of it.
constexpr double kEnergyShare = 0.1;
constexpr double kLeastEnergyTolerance = 1e-10;
// Neighbouring steps that keep the discrete energy differ by this factor at most.
constexpr double kLargestChange = 2.0;

// A step is refused by time.retry if the energy error is above the first share of the energy that
// entered, and has grown by more than the second one in this step.
constexpr double kLargestError = 1.0;
constexpr double kLargestAddition = 0.1;

// Takes back what was entered in the balance, unless all went well.
class BalanceGuard {
 public:
  explicit BalanceGuard(Balance& balance) : balance_(balance), before_(balance.sums()) {}
  ~BalanceGuard() {
    if (!kept_) balance_.restore(std::move(before_));
  }
  BalanceGuard(const BalanceGuard&) = delete;
  BalanceGuard& operator=(const BalanceGuard&) = delete;
  void keep() { kept_ = true; }

 private:
  Balance& balance_;
  BalanceSums before_;
  bool kept_ = false;
};

// The largest distance between the positions of a vertex, m.
double largest_distance(const MeshPart* part, const Vector& a, const Vector& b) {
  const double square = (a - b).reshaped(3, a.size() / 3).colwise().squaredNorm().maxCoeff();
  return std::sqrt(largest_of_parts(part, square));
}

// Calls use(term) for the potentials that are not among the stored energies.
void for_each_driven_potential(const MechanicalSystem& system, const auto& use) {
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential() && term->account() != EnergyAccount::kStored) use(*term);
  }
}

}  // namespace

bool Session::Impl::follows_limit() const {
  return !is_implicit(settings.time.integrator) && (settings.time.automatic || adapts());
}

StepBounds Session::Impl::bounds_of_steps() const {
  StepBounds bounds = step_bounds(settings.time, progress.first_time_step);
  if (follows_limit()) {
    bounds.most = std::min(bounds.most, kStableShare * progress.plan.automatic.critical_step);
    bounds.least = std::min(bounds.least, bounds.most);
  }
  return bounds;
}

void Session::Impl::warn_of_smaller_steps() {
  const TimeSettings& time = settings.time;
  if (!follows_limit() || !adapts() || !time.min_step) return;
  if (*time.min_step <= kStableShare * progress.plan.automatic.critical_step) return;
  std::string warning = fmt::format(
      "time.min_step = {:.4g} s is above {} of the stability limit of {}, or came to be so: the "
      "steps are smaller there, because longer ones would blow up. Take a smaller time.min_step, "
      "or "
      "an implicit integrator.",
      *time.min_step, kStableShare, to_string(time.integrator));
  if (std::find(progress.warnings.begin(), progress.warnings.end(), warning) ==
      progress.warnings.end()) {
    progress.warnings.push_back(std::move(warning));
  }
}

double Session::Impl::next_landing() const {
  double next = settings.time.end;
  if (progress.next_event < scene.event.size()) {
    next = std::min(next, scene.event[progress.next_event].at);
  }
  return landing > state().time ? std::min(next, landing) : next;
}

Session::Impl::Span Session::Impl::span_of(double length, double landing_time) const {
  const Span span{length, state().time + length};
  if (!(std::abs(span.end - landing_time) <= kMerged * length)) return span;
  const double left = landing_time - state().time;
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(landing_time);
  return {std::abs(left - length) <= round_off ? length : left, landing_time};
}

bool Session::Impl::refuse_energy(StepOutcome& outcome, double error_before) const {
  const double error = balance->energy_error();
  const double added = error - error_before;
  const bool is_too_much =
      relative_energy(error) > kLargestError && !(relative_energy(added) <= kLargestAddition);
  if (!is_too_much && !blown_up()) return false;
  outcome.status = StepStatus::kNotFinite;
  outcome.message = fmt::format(
      "the energy grows: the integrator has added {:.3g} J in this step and {:.3g} J altogether to "
      "the {:.3g} J that entered",
      added, error, balance->energy_scale());
  return true;
}

Session::Impl::Work Session::Impl::work_so_far() const {
  return {progress.total_iterations, progress.total_factorizations, progress.total_cg_iterations};
}

void Session::Impl::report_work_since(const Work& before) {
  const Work now = work_so_far();
  MinimizerReport& report = progress.last_report;
  report.iterations = static_cast<int>(now.iterations - before.iterations);
  report.factorizations = static_cast<int>(now.factorizations - before.factorizations);
  report.cg_iterations = static_cast<int>(now.cg_iterations - before.cg_iterations);
}

// The step is divided into pieces of h/2^n. A sub-step takes 2^(n − level) of them. After sub-steps
// that succeeded its size doubles again as soon as the next one of that size begins at a multiple
// of it.
StepOutcome Session::Impl::advance_in_halves(StepOutcome failure) {
  StepControl& control = progress.control;
  const Span span = planned_span();
  const double begin = state().time;
  const int levels = settings.time.retry;
  const Index pieces = Index{1} << levels;
  const double piece = span.length / static_cast<double>(pieces);
  const auto enter_failure = [&] {
    ++control.rejected;
    ++control.failed;
    ++control.last_rejected;
    stepper->reset();
  };
  enter_failure();
  BalanceGuard guard(*balance);
  Reactions mean;
  const State* from = &state();
  State* to = &work_states.middle;
  State* unused = &work_states.whole;
  const Work before = work_so_far();
  Index done = 0;
  int level = 1;
  Index substeps = 0;
  double smallest = span.length;
  StepOutcome outcome = std::move(failure);
  while (done < pieces) {
    if (cancelled_within_step()) return outcome;
    const Index taken = pieces >> level;
    const double length = static_cast<double>(taken) * piece;
    const double end =
        done + taken == pieces ? span.end : begin + static_cast<double>(done + taken) * piece;
    outcome = stepper->advance(*from, *to, length, end);
    count(outcome.minimizer);
    if (outcome.ok()) {
      balance_before = balance->sums();
      const double error_before = balance->energy_error();
      balance->enter(*to, outcome);
      if (refuse_energy(outcome, error_before)) balance->restore(balance_before);
    }
    if (!outcome.ok()) {
      enter_failure();
      if (level == levels) return outcome;
      ++level;
      continue;
    }
    mean.add(stepper->reactions(), length / span.length, span.end - end);
    done += taken;
    ++substeps;
    smallest = std::min(smallest, length);
    from = to;
    std::swap(to, unused);
    if (level > 1 && done % (pieces >> (level - 1)) == 0) --level;
  }
  const Index number = state().step + 1;
  states.other() = *from;
  states.other().step = number;
  stepper->set_reactions(mean);
  guard.keep();
  accept_step();
  enter_length(span.length, span.length < progress.plan.time_step);
  progress.steps.smallest = std::min(progress.steps.smallest, smallest);
  report_work_since(before);
  ++control.retried;
  control.last_substeps = substeps;
  return outcome;
}

Session::Impl::Halves Session::Impl::try_halves(const Span& span) {
  Halves halves;
  if (!whole_stepper) {
    whole_stepper = make_stepper(settings.time.integrator, settings.solver, *system);
  }
  // It never steps from where it arrived.
  whole_stepper->reset();
  halves.second = whole_stepper->advance(state(), work_states.whole, span.length, span.end);
  count(halves.second.minimizer);
  if (!halves.second.ok()) return halves;
  const double half = 0.5 * span.length;
  halves.second = halves.first =
      stepper->advance(state(), work_states.middle, half, state().time + half);
  count(halves.first.minimizer);
  if (!halves.first.ok()) return halves;
  halves.reactions.add(stepper->reactions(), 0.5, half);
  halves.second = stepper->advance(work_states.middle, states.other(), half, span.end);
  count(halves.second.minimizer);
  if (!halves.second.ok()) return halves;
  halves.reactions.add(stepper->reactions(), 0.5, 0.0);
  if (rest_diagonal == 0.0) rest_diagonal = bounding_box(system->mesh()).diagonal();
  const int order_of_rule = order(settings.time.integrator);
  halves.error =
      largest_distance(system->part(), states.other().position, work_states.whole.position) /
      ((std::ldexp(1.0, order_of_rule) - 1.0) * rest_diagonal);
  return halves;
}

void Session::Impl::accept_halves(const Halves& halves, const Span& span) {
  system->applied_force(state().position, state().time, span.length, trial_external_force);
  BalanceGuard guard(*balance);
  balance->enter(work_states.middle, halves.first);
  balance->enter(states.other(), halves.second);
  guard.keep();
  states.other().step = state().step + 1;
  stepper->set_reactions(halves.reactions);
  accept_step();
  if (follows_limit()) automatic().watch_elastic(halves.second.elastic_energy, state().step);
  progress.control.last_substeps = 2;
  progress.control.last_error = halves.error;
}

StepOutcome Session::Impl::advance_by_error() {
  StepControl& control = progress.control;
  StepController controller(progress.plan.adaptive, order(settings.time.integrator));
  const StepBounds bounds = bounds_of_steps();
  const double landing_time = next_landing();
  const Work before = work_so_far();
  const auto error_of = [&](const Halves& halves) {
    return halves.second.ok() ? halves.error / settings.time.tolerance
                              : std::numeric_limits<double>::infinity();
  };
  const auto is_acceptable = [&](const Halves& halves, const Span& span) {
    return halves.second.ok() && (error_of(halves) <= 1.0 || span.length <= bounds.least);
  };
  double length = std::clamp(progress.plan.time_step, bounds.least, bounds.most);
  for (;;) {
    Span span = span_of(length, landing_time);
    Halves halves = try_halves(span);
    const bool is_rejected = !is_acceptable(halves, span) && span.length > bounds.least;
    if (is_rejected && cancelled_within_step()) return std::move(halves.second);
    bool is_cut = false;
    // A step is cut only after the full one was accepted. Rejections are then the same whether an
    // edit is made between two steps or at a time on which the steps land.
    if (is_acceptable(halves, span) && span.end > landing_time) {
      is_cut = true;
      span = {landing_time - state().time, landing_time};
      stepper->reset();
      halves = try_halves(span);
    }
    const double error = error_of(halves);
    if (is_acceptable(halves, span)) {
      if (error > 1.0) ++control.above_tolerance;
      accept_halves(halves, span);
      report_work_since(before);
      enter_length(span.length, is_cut);
      if (!is_cut) {
        length *= controller.after_success(error, control.last_rejected > 0);
      }
      set_time_step(std::clamp(length, bounds.least, bounds.most));
      return std::move(halves.second);
    }
    ++control.rejected;
    ++control.last_rejected;
    if (!halves.second.ok()) ++control.failed;
    stepper->reset();
    if (span.length <= bounds.least) {
      set_time_step(span.length);
      report_work_since(before);
      return std::move(halves.second);
    }
    length = std::max(bounds.least, span.length * controller.after_rejection(error));
  }
}

double Session::Impl::full_energy(const State& at, double& magnitude) const {
  Energies energies = balance->energies();
  if (!evaluate_energies(*system, at, energies).ok())
    return std::numeric_limits<double>::quiet_NaN();
  double energy = energies.total();
  magnitude = 0.0;
  for (const Energies::Entry& entry : energies.entries()) magnitude += std::abs(entry.value);
  const ForcePoint point = system->force_point(at.position, at.time);
  for_each_driven_potential(*system, [&](const ForceTerm& term) {
    const double value = sum_over_parts(system->part(), term.energy(point));
    energy += value;
    magnitude += std::abs(value);
  });
  return energy;
}

// The discrete energy of the midpoint rule is −∂L_d/∂h of its discrete Lagrangian L_d = h L(½(q_k +
// q_{k+1}), v): kinetic energy of v and the potentials in the middle.
Session::Impl::EnergyTrial Session::Impl::try_energy(const Span& span) {
  EnergyTrial trial;
  const State& from = state();
  State& to = states.other();
  trial.outcome = stepper->advance(from, to, span.length, span.end);
  count(trial.outcome.minimizer);
  if (!trial.outcome.ok()) return trial;
  work_states.middle.time = from.time + 0.5 * span.length;
  work_states.middle.position = 0.5 * (from.position + to.position);
  work_states.middle.velocity = to.velocity;
  system->momentum_of(to.velocity, work_states.middle.momentum);
  trial.energy = full_energy(work_states.middle, trial.magnitude);
  double work =
      trial.outcome.external_work + trial.outcome.constraint_work - trial.outcome.dissipated_energy;
  const ForcePoint start = system->force_point(from.position, from.time);
  const ForcePoint end = system->force_point(to.position, to.time);
  for_each_driven_potential(*system, [&](const ForceTerm& term) {
    // It is part of the discrete energy.
    work += sum_over_parts(system->part(), term.energy_change(start, end));
  });
  trial.half_work = 0.5 * work;
  return trial;
}

StepOutcome Session::Impl::advance_by_energy() {
  StepControl& control = progress.control;
  AdaptiveStepMemory& memory = progress.plan.adaptive;
  const StepBounds bounds = bounds_of_steps();
  const double landing_time = next_landing();
  const double present = std::clamp(progress.plan.time_step, bounds.least, bounds.most);
  const Work before = work_so_far();
  const bool keeps = memory.has_energy;
  const double kept = memory.energy + memory.half_work;
  double magnitude = 0.0;
  const double at_zero = keeps ? full_energy(state(), magnitude) - kept : 0.0;
  const double tolerance =
      std::max(kLeastEnergyTolerance, kEnergyShare * settings.solver.tolerance) /
          relative_energy(1.0) +
      16.0 * std::numeric_limits<double>::epsilon() * magnitude;

  EnergyTrial last;
  double last_length = 0.0;
  bool present_fails = false;
  const auto make_trial = [&](const Span& span) {
    if (last_length > 0.0) {
      if (progress.status == RunStatus::kCancelled || cancelled_within_step()) return false;
      stepper->reset();
    }
    last = try_energy(span);
    last_length = span.length;
    if (last.outcome.ok() && std::isfinite(last.energy)) return true;
    present_fails = present_fails || span.length == present;
    ++control.rejected;
    ++control.failed;
    ++control.last_rejected;
    return false;
  };
  const auto residual = [&](double length) -> std::optional<double> {
    if (!make_trial({length, state().time + length})) return std::nullopt;
    return keeps ? last.energy - kept - last.half_work : 0.0;
  };
  const auto give_up = [&] {
    stepper->reset();
    set_time_step(last_length);
    report_work_since(before);
    if (last.outcome.ok()) last.outcome.status = StepStatus::kInverted;  // no discrete energy
    return std::move(last.outcome);
  };
  const StepBounds range{std::max(bounds.least, present / kLargestChange),
                         std::min(bounds.most, present * kLargestChange)};
  StepRoot root = find_step(residual, present, at_zero, range, tolerance);
  if (root.step == 0.0 && range.least > bounds.least && progress.status == RunStatus::kRunning) {
    root = find_step(residual, range.least, at_zero, {bounds.least, range.least}, tolerance);
  }

  if (progress.status == RunStatus::kCancelled) return std::move(last.outcome);
  if (root.step == 0.0) return give_up();

  // The least residual would lead to ever smaller steps: see docs/theory.md.
  const double chosen = root.found || present_fails ? root.step : present;
  Span span = span_of(chosen, landing_time);
  const bool is_cut = span.end > landing_time;
  if (is_cut) span = {landing_time - state().time, landing_time};
  // The last trial is that of a solution, unless its end is not exactly the landing.
  const bool is_made = last_length == span.length && span.end == state().time + span.length;
  if (!is_made && !make_trial(span)) {
    return progress.status == RunStatus::kCancelled ? std::move(last.outcome) : give_up();
  }
  system->applied_force(state().position, state().time, span.length, trial_external_force);
  balance->enter(states.other(), last.outcome);
  accept_step();
  report_work_since(before);
  enter_length(span.length, is_cut);
  if (keeps && !root.found && !is_cut) ++control.without_solution;
  // A step that was cut has another discrete energy; it must not become the one to keep.
  if (keeps || !is_cut) {
    memory.energy = keeps ? kept + last.half_work : last.energy;
    memory.half_work = last.half_work;
    memory.has_energy = true;
  }
  control.discrete_energy = last.energy;
  control.energy_residual = memory.has_energy ? last.energy - memory.energy : 0.0;
  set_time_step(chosen);
  return std::move(last.outcome);
}

bool Session::Impl::any_time_settings(
    const std::function<bool(const TimeSettings&)>& are_such) const {
  if (loading) return false;
  if (are_such(settings.time)) return true;
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const auto* change = std::get_if<SetTime>(&edit);
      if (change != nullptr && are_such(change->time)) return true;
    }
  }
  return false;
}

const StepControl& Session::step_control() const {
  return impl_->progress.control;
}

bool Session::may_repeat_steps() const {
  const auto may = [](const TimeSettings& time) {
    return time.retry > 0 || time.adapt != StepAdaptation::kNone;
  };
  return impl_->any_time_settings(may);
}

bool Session::may_adapt(StepAdaptation adaptation) const {
  return impl_->any_time_settings(
      [adaptation](const TimeSettings& time) { return time.adapt == adaptation; });
}

void Session::land_at(double time) {
  impl_->landing = time;
}

void Session::Impl::warn_of_step_control() {
  const StepControl& control = progress.control;
  if (control.retried > 0) {
    progress.warnings.push_back(fmt::format(
        "{} of {} steps failed at their full size and were made in smaller ones (time.retry), the "
        "smallest of {:.4g} s. history.csv has their number in the column substeps.",
        control.retried, state().step, progress.steps.smallest));
  }
  if (control.above_tolerance > 0) {
    progress.warnings.push_back(
        fmt::format("{} of {} steps are less exact than time.tolerance = {:.3g}: smaller ones than "
                    "time.min_step "
                    "would be needed. history.csv has their errors in the column step_error.",
                    control.above_tolerance, state().step, settings.time.tolerance));
  }
  if (control.without_solution > 0) {
    progress.warnings.push_back(fmt::format(
        "in {} of {} steps no size between the bounds keeps the discrete energy: the size of the "
        "step before was taken. history.csv has what is missing in the column energy_residual.",
        control.without_solution, state().step));
  }
}

}  // namespace tetraction
