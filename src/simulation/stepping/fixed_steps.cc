// Steps of the size that the settings give, and steps that are repeated in smaller ones (time.retry).
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "step_strategy.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

class FixedSteps final : public StepStrategy {
 public:
  explicit FixedSteps(RunData& run) : StepStrategy(run) {}

  StepOutcome advance() override { return attempt_and_accept(run_, planned_span()); }

  std::string advice(double limit) const override {
    const double step = run_.progress.plan.time_step;
    if (!is_implicit(time().integrator)) {
      return fmt::format(
          "The step is {:.4g} s; the stability limit is {:.4g} s (initially {:.4g} s). Take a step "
          "below it, time.step = \"auto\", or an implicit integrator.",
          step, limit, run_.initial_limit.critical_step);
    }
    return fmt::format(
        "The step is {:.4g} s, {:.3g} times the explicit stability limit of {:.4g} s. Take a "
        "smaller time.step{}, and check the loads.",
        step, step / limit, limit,
        time().integrator == Integrator::kEnergyMomentum ? " or backward-euler" : other_rule());
  }

  std::string energy_warning(double share) const override {
    const double step = run_.progress.plan.time_step;
    const double frequency = resolved_frequency(time().integrator, step);
    if (time().integrator != Integrator::kBackwardEuler) {
      return fmt::format(
          "the energy error reached {:.3g} % of the energy that entered: the step does not resolve "
          "the motion. {:.4g} s resolve vibrations up to {:.3g} Hz (20 steps a period). Take a "
          "smaller time.step{}.",
          100.0 * share, step, frequency, other_rule());
    }
    return fmt::format(
        "the energy error reached {:.3g} % of the energy that entered: backward-euler damps what "
        "the step does not resolve, which is right on the way to rest and wrong for a motion. With "
        "{:.4g} s vibrations up to {:.3g} Hz keep nine tenths of their energy over a period. Take "
        "a smaller time.step, or midpoint.",
        100.0 * share, step, frequency);
  }
};

class RetriedSteps final : public StepStrategy {
 public:
  RetriedSteps(RunData& run, std::unique_ptr<StepStrategy> steps)
      : StepStrategy(run), steps_(std::move(steps)) {}

  StepOutcome advance() override {
    StepOutcome outcome = steps_->advance();
    if (outcome.ok() || run_.progress.status == RunStatus::kCancelled) return outcome;
    return advance_in_halves(std::move(outcome));
  }

  std::string advice(double /*limit*/) const override {
    return fmt::format(
        "The step of {:.4g} s was halved {} times (time.retry), which did not help. Take a smaller "
        "time.step or a larger time.retry{}, and check the loads.",
        run_.progress.plan.time_step, time().retry, other_rule());
  }
  std::string energy_warning(double share) const override { return steps_->energy_warning(share); }
  void renew(const StabilityLimit& limit, CriticalModes modes) override {
    steps_->renew(limit, std::move(modes));
  }
  std::optional<StepCollapse> follow_limit() override { return steps_->follow_limit(); }
  void begin_to_follow(const StabilityLimit& limit, CriticalModes modes) override {
    steps_->begin_to_follow(limit, std::move(modes));
  }

 private:
  StepOutcome advance_in_halves(StepOutcome failure);
  void enter_failure() {
    StepControl& control = run_.progress.control;
    ++control.rejected;
    ++control.failed;
    ++control.last_rejected;
    run_.memory.stepper->reset();
  }

  std::unique_ptr<StepStrategy> steps_;
};

// The step is divided into pieces of h/2^n. A sub-step takes 2^(n − level) of them. After sub-steps
// that succeeded its size doubles again as soon as the next one of that size begins at a multiple
// of it.
StepOutcome RetriedSteps::advance_in_halves(StepOutcome failure) {
  RunProgress& progress = run_.progress;
  Stepper& stepper = *run_.memory.stepper;
  const StepSpan span = planned_span();
  const double begin = run_.state().time;
  const int levels = time().retry;
  const Index pieces = Index{1} << levels;
  const double piece = span.length / static_cast<double>(pieces);
  enter_failure();
  auto guard = balance_guard(*run_.balance);
  Reactions mean;
  const State* from = &run_.state();
  State* to = &run_.work.middle;
  State* unused = &run_.work.whole;
  const IterationCount iterations(progress);
  Index done = 0;
  int level = 1;
  Index substeps = 0;
  double smallest = span.length;
  StepOutcome outcome = std::move(failure);
  while (done < pieces) {
    if (is_cancelled_within_step(run_)) return outcome;
    const Index taken = pieces >> level;
    const double length = static_cast<double>(taken) * piece;
    const double end =
        done + taken == pieces ? span.end : begin + static_cast<double>(done + taken) * piece;
    outcome = attempt(run_, *from, *to, {length, end});
    if (!outcome.ok()) {
      enter_failure();
      if (level == levels) return outcome;
      ++level;
      continue;
    }
    mean.add(stepper.reactions(), length / span.length, span.end - end);
    done += taken;
    ++substeps;
    smallest = std::min(smallest, length);
    from = to;
    std::swap(to, unused);
    if (level > 1 && done % (pieces >> (level - 1)) == 0) --level;
  }
  const Index number = run_.state().step + 1;
  run_.states.other() = *from;
  run_.states.other().step = number;
  stepper.set_reactions(mean);
  guard.release();
  accept_step(run_);
  enter_length(progress, span.length, span.length < progress.plan.time_step);
  progress.steps.smallest = std::min(progress.steps.smallest, smallest);
  iterations.report();
  ++progress.control.retried;
  progress.control.last_substeps = substeps;
  return outcome;
}

}  // namespace

std::unique_ptr<StepStrategy> make_fixed_steps(RunData& run) {
  return std::make_unique<FixedSteps>(run);
}

std::unique_ptr<StepStrategy> make_retried_steps(RunData& run,
                                                 std::unique_ptr<StepStrategy> steps) {
  return std::make_unique<RetriedSteps>(run, std::move(steps));
}

std::string retry_warning(const RunProgress& progress, Index step) {
  if (progress.control.retried == 0) return {};
  return fmt::format(
      "{} of {} steps failed at their full size and were made in smaller ones (time.retry), the "
      "smallest of {:.4g} s. history.csv has their number in the column substeps.",
      progress.control.retried, step, progress.steps.smallest);
}

}  // namespace tetraction
