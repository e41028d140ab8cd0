// time.step = "auto": steps of half the stability limit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "automatic_step.h"
#include "limit_estimates.h"
#include "step_strategy.h"

namespace tetraction {
namespace {

// A step is repeated with a smaller size if the energy error changes in it by more than
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
// The run ends if its steps would be shorter than this share of the first ones.
constexpr double kShortest = 1e-6;

class AutomaticSteps final : public StepStrategy {
 public:
  explicit AutomaticSteps(RunData& run) : StepStrategy(run) {}

  StepOutcome advance() override;
  std::string advice(double limit) const override {
    return fmt::format(
        "The steps were half of the stability limit, which has come down to {:.4g} s (initially "
        "{:.4g} s). Check loads and prescribed motion, end the run earlier, or take an implicit "
        "integrator.",
        limit, run_.initial_limit.critical_step);
  }
  std::string energy_warning(double share) const override {
    return fmt::format(
        "the energy error reached {:.3g} % of the energy that entered: time.step = \"auto\" keeps "
        "steps stable, but they do not resolve the motion. Give time.step in seconds, below {:.4g} "
        "s.",
        100.0 * share, run_.progress.steps.smallest);
  }
  void renew(const StabilityLimit& limit, CriticalModes modes) override;
  std::optional<StepCollapse> follow_limit() override;
  void begin_to_follow(const StabilityLimit& limit, CriticalModes modes) override {
    start_to_follow(run_, automatic_limit(run_, limit), std::move(modes));
  }

 private:
  // An attempt, and the share of the energy that entered by which the energy error changed in it; 0
  // if this is not known.
  struct Attempt {
    StepOutcome outcome;
    double energy_share = 0.0;
  };
  Attempt attempt_step(double most_energy_share);
  StepOutcome advance_in_smaller_steps(Attempt last);
  double step_beside_obstacles(double step);
  AutomaticStep automatic() { return AutomaticStep(plan().automatic); }
  StepPlan& plan() { return run_.progress.plan; }
};

void AutomaticSteps::renew(const StabilityLimit& limit, CriticalModes modes) {
  const double critical = automatic_limit(run_, limit);
  if (!std::isfinite(critical)) return;
  // The step stays as it is if it is hardly too large and not much too small.
  const double wanted = AutomaticStep::kShare * critical;
  if (plan().time_step > 1.001 * wanted || plan().time_step < 0.8 * wanted) {
    set_time_step(run_, wanted);
  }
  start_to_follow(run_, critical, std::move(modes));
  run_.progress.first_time_step = plan().time_step;
}

// A layer shortens the step at once. When it is free again the step grows back to that of the body alone, by doubling.
double AutomaticSteps::step_beside_obstacles(double step) {
  constexpr double kMuch = 1.1;
  constexpr double kLittle = 0.75;
  constexpr Index kInterval = 32;
  if (run_.system->contact() == nullptr) return step;
  const double body = automatic().least_recent();
  const double most = AutomaticStep::kShare * limit_beside_obstacles(run_, body, step);
  if (step > kMuch * most) return most;
  if (run_.state().step % kInterval == 0 && step < kLittle * most) {
    return std::min(2.0 * step, most);
  }
  return step;
}

std::optional<StepCollapse> AutomaticSteps::follow_limit() {
  double step = plan().time_step;
  if (automatic().is_due(run_.state().step)) step = enter_estimate(run_);
  step = step_beside_obstacles(step);
  if (!(step > kShortest * run_.progress.first_time_step)) {
    return StepCollapse{fmt::format("stability would need steps of {:.3g} s, less than a millionth "
                                    "of the first one: the body is crushed or torn",
                                    step),
                        critical_element(*run_.system, automatic().modes())};
  }
  if (step != plan().time_step) set_time_step(run_, step);
  return std::nullopt;
}

AutomaticSteps::Attempt AutomaticSteps::attempt_step(double most_energy_share) {
  Attempt made;
  const auto check = [&](StepOutcome& outcome, double error_before) {
    const Balance& balance = *run_.balance;
    const double change = balance.energy_error() - error_before;
    made.energy_share = relative_energy(run_, std::abs(change));
    if (!(made.energy_share <= most_energy_share)) {
      outcome.status = StepStatus::kNotFinite;
      outcome.message = fmt::format(
          "the integrator changes the energy by {:.3g} J, {:.3g} % of what entered, in one step",
          change, 100.0 * made.energy_share);
      return;
    }
    const Index number = run_.states.other().step;
    automatic().watch(change, balance.energy_scale(), number);
    automatic().watch_elastic(outcome.elastic_energy, number);
  };
  made.outcome = attempt_and_accept(run_, planned_span(), check);
  return made;
}

StepOutcome AutomaticSteps::advance() {
  Attempt first = attempt_step(largest_energy_share(time().integrator));
  if (!was_too_large(first.outcome.status)) return std::move(first.outcome);
  const StepPlan before = plan();
  const Index changes = run_.progress.steps.changes;
  const auto take_back_plan = [&] {
    plan() = before;
    run_.progress.steps.changes = changes;
  };
  try {
    StepOutcome outcome = advance_in_smaller_steps(std::move(first));
    if (was_too_large(outcome.status)) take_back_plan();
    return outcome;
  } catch (...) {
    take_back_plan();
    throw;
  }
}

// The limit has decreased faster than the step followed it, or the step does not resolve the motion.
StepOutcome AutomaticSteps::advance_in_smaller_steps(Attempt last) {
  constexpr int kHalvings = 20;
  RunProgress& progress = run_.progress;
  const Index changes = progress.steps.changes;
  const double step_before = plan().time_step;
  CriticalModes modes;
  const double critical = automatic_limit(run_, timed_limit(run_, run_.state().position, &modes));
  run_.memory.impact = {};
  double step =
      std::min(0.5 * plan().time_step,
               AutomaticStep::kShare * limit_beside_obstacles(run_, critical, plan().time_step));
  // The plan of the last attempt whose error fell, and how many came after that.
  StepPlan best = plan();
  int unhelpful = 0;
  for (int i = 0; i < kHalvings && step > kShortest * progress.first_time_step; ++i, step *= 0.5) {
    if (is_cancelled_within_step(run_)) return std::move(last.outcome);
    set_time_step(run_, step);
    automatic().start(critical, modes, run_.state().step);
    Attempt next = attempt_step(largest_energy_share(time().integrator));
    if (!was_too_large(next.outcome.status)) {
      progress.steps.changes = changes + 1;
      return std::move(next.outcome);
    }
    // The error of a step that resolves the motion falls at least with the square of its size. An
    // error that does not fall is that of a sudden event, such as a support that begins to move.
    if (!(last.energy_share > 0.0) || next.energy_share < kFalling * last.energy_share) {
      best = plan();
      unhelpful = 0;
    } else if (++unhelpful == 2) {
      plan() = best;
      progress.steps.changes = changes + (best.time_step == step_before ? 0 : 1);
      return attempt_step(kMostEnergyShare).outcome;
    }
    last = std::move(next);
  }
  return std::move(last.outcome);
}

}  // namespace

std::unique_ptr<StepStrategy> make_automatic_steps(RunData& run) {
  return std::make_unique<AutomaticSteps>(run);
}

}  // namespace tetraction
