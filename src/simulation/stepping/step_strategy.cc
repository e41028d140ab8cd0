#include "step_strategy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "adaptations.h"
#include "automatic_step.h"
#include "limit_estimates.h"
#include "step_count.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A step is refused by time.retry if the energy error is above the first share of the energy that
// entered, and has grown by more than the second one in this step.
constexpr double kLargestError = 1.0;
constexpr double kLargestAddition = 0.1;

void refuse_energy(const RunData& run, StepOutcome& outcome, double error_before) {
  const double error = run.balance->energy_error();
  const double added = error - error_before;
  const bool is_too_much = relative_energy(run, error) > kLargestError &&
                           !(relative_energy(run, added) <= kLargestAddition);
  if (!is_too_much && !has_blown_up(run)) return;
  outcome.status = StepStatus::kNotFinite;
  outcome.message = fmt::format(
      "the energy grows: the integrator has added {:.3g} J in this step and {:.3g} J altogether to "
      "the {:.3g} J that entered",
      added, error, run.balance->energy_scale());
}

}  // namespace

bool is_automatic(const TimeSettings& time) {
  return time.automatic && !adapts(time) && !is_implicit(time.integrator);
}

bool follows_limit(const TimeSettings& time) {
  return !is_implicit(time.integrator) && (time.automatic || adapts(time));
}

bool is_due(double at, double now, const TimeSettings& time, double time_step) {
  return at <= now + (adapts(time) ? round_off_of_time(at) : 1e-6 * time_step);
}

bool was_too_large(StepStatus status) {
  return status == StepStatus::kInverted || status == StepStatus::kNotFinite ||
         status == StepStatus::kOverdamped || status == StepStatus::kUndefined;
}

double StepStrategy::first_step(const StabilityLimit& limit) const {
  return time().automatic ? AutomaticStep::kShare * automatic_limit(run_, limit) : time().step;
}

void StepStrategy::choose_step(const StabilityLimit& limit, CriticalModes modes) {
  const double first = first_step(limit);
  const double step = stable_step(first, limit);
  if (!(step > 0.0) || !std::isfinite(step)) {
    throw InputError(
        "time.step = \"auto\" finds no stability limit for this body: give the step in seconds.");
  }
  const double end = time().end;
  const double left = end - run_.state().time;
  if (std::isfinite(end) && left / step > kMostSteps) {
    throw InputError(
        fmt::format("The run has {:.3g} steps, more than can be counted: make time.step = {} s "
                    "larger or time.end = {} s earlier.",
                    left / step, step, end));
  }
  const double shortest = left > round_off_of_time(end) ? std::min(left, step) : step;
  if (!std::isnormal(shortest * shortest) || !std::isnormal(1.0 / (shortest * shortest))) {
    throw InputError(
        fmt::format("A step of {:.3g} s cannot be computed: the square of its length, or one over "
                    "it, is out of the range of double precision. Make {} {}.",
                    shortest, shortest < step ? "time.end" : "time.step",
                    shortest < 1.0 ? "larger" : "smaller"));
  }
  set_time_step(run_, step);
  run_.progress.first_time_step = first;
  begin_to_follow(limit, std::move(modes));
}

StepSpan StepStrategy::planned_span() const {
  const StepPlan& plan = run_.progress.plan;
  const double h = plan.time_step;
  const Index number = run_.state().step - plan.segment_step + 1;
  // The time is a multiple of h, not a running sum, so that it has no accumulated round-off.
  StepSpan span{h, plan.segment_time + static_cast<double>(number) * h};
  if (number == plan.segment_count && std::isfinite(time().end)) {
    span.end = time().end;
    const double left = span.end - run_.state().time;
    if (std::abs(left - h) > round_off_of_time(span.end)) span.length = left;
  }
  return span;
}

std::string StepStrategy::other_rule() const {
  if (time().integrator != Integrator::kMidpoint) return {};
  return run_.system->part() == nullptr
             ? ", or integrator = \"energy-momentum\", which keeps the energy also where steps do "
               "not resolve the motion, such as the spin of a stiff body"
             : ", or integrator = \"backward-euler\"";
}

StepOutcome attempt(RunData& run, const State& from, State& to, const StepSpan& span,
                    const StepCheck& check) {
  Balance& balance = *run.balance;
  StepOutcome outcome = run.memory.stepper->advance(from, to, span.length, span.end);
  count_iterations(run.progress, outcome.minimizer);
  if (!outcome.ok()) return outcome;
  run.work.balance_before = balance.sums();
  const double error_before = balance.energy_error();
  balance.enter(to, outcome);
  if (check) check(outcome, error_before);
  if (outcome.ok() && run.settings.time.retry > 0) refuse_energy(run, outcome, error_before);
  if (outcome.ok() && !std::isfinite(balance.energies().total())) {
    outcome.status = StepStatus::kNotFinite;
  }
  if (!outcome.ok()) {
    balance.restore(run.work.balance_before);
    run.memory.stepper->reset();
  }
  return outcome;
}

StepOutcome attempt_and_accept(RunData& run, const StepSpan& span, const StepCheck& check) {
  const State& from = run.state();
  run.system->applied_force(from.position, from.time, span.length, run.work.external_force);
  StepOutcome outcome = attempt(run, from, run.states.other(), span, check);
  if (!outcome.ok()) return outcome;
  accept_step(run);
  enter_length(run.progress, span.length, span.length < run.progress.plan.time_step);
  return outcome;
}

IterationCount::IterationCount(RunProgress& progress)
    : progress_(progress),
      iterations_(progress.total_iterations),
      factorizations_(progress.total_factorizations),
      cg_iterations_(progress.total_cg_iterations) {}

void IterationCount::report() const {
  MinimizerReport& report = progress_.last_report;
  report.iterations = static_cast<int>(progress_.total_iterations - iterations_);
  report.factorizations = static_cast<int>(progress_.total_factorizations - factorizations_);
  report.cg_iterations = static_cast<int>(progress_.total_cg_iterations - cg_iterations_);
}

std::unique_ptr<StepStrategy> make_step_strategy(RunData& run) {
  const TimeSettings& time = run.settings.time;
  if (adapts(time)) return adaptation(time.adapt).make_strategy(run);
  std::unique_ptr<StepStrategy> steps =
      is_automatic(time) ? make_automatic_steps(run) : make_fixed_steps(run);
  return time.retry > 0 ? make_retried_steps(run, std::move(steps)) : std::move(steps);
}

}  // namespace tetraction
