// The size of a session's steps, and one step of that size.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/scope_exit.h"
#include "run_data.h"

namespace tetraction {

/// Whether steps adapt (time.adapt).
inline bool adapts(const TimeSettings& time) {
  return time.adapt != StepAdaptation::kNone;
}
/// Whether all steps follow the stability limit (time.step = "auto").
bool is_automatic(const TimeSettings& time);
/// Whether the steps are bounded by the stability limit, which is estimated again as the body moves.
bool follows_limit(const TimeSettings& time);
/// Whether an event at the time `at` is due at the time `now` of a run. Steps of equal size begin at multiples of it,
/// which have round-off: there an event counts that is less than a millionth of the step away. Adapted steps
/// end at the times of events themselves.
bool is_due(double at, double now, const TimeSettings& time, double time_step);

/// The length of a step and the time of its end, s.
struct StepSpan {
  double length = 0.0;
  double end = 0.0;
};

/// The reason for which a run cannot go on although no step has failed.
struct StepCollapse {
  std::string what;    ///< one clause
  Index element = -1;  ///< the element that is concerned, or −1
};

/// Chooses the size of steps, and makes a step of that size. An object keeps a reference to the data of
/// the run. It has no memory: what it must remember is in RunProgress (and so in checkpoints) or StepMemory.
class StepStrategy {
 public:
  virtual ~StepStrategy() = default;
  StepStrategy(const StepStrategy&) = delete;
  StepStrategy& operator=(const StepStrategy&) = delete;

  /// Makes one step, in as many attempts as the strategy takes. If it succeeds, the state, balance and
  /// plan of the run are those after it, otherwise as before.
  virtual StepOutcome advance() = 0;
  /// Advice to the user after a failed step. `limit`: the smaller one of the stability limits at the
  /// start and now, s.
  virtual std::string advice(double limit) const = 0;
  /// The warning after a run whose energy error reached this share of the energy that entered.
  virtual std::string energy_warning(double share) const = 0;

  /// Sets the first step at the present state from the settings and the stability limit. Throws
  /// InputError if there is none.
  void choose_step(const StabilityLimit& limit, CriticalModes modes);
  /// Takes notice of an edit that may have changed the stability limit.
  virtual void renew(const StabilityLimit& /*limit*/, CriticalModes /*modes*/) {}
  /// Called before each step: estimates the stability limit again if an estimate is due.
  virtual std::optional<StepCollapse> follow_limit() { return std::nullopt; }
  /// Begins to follow the limit after the first step was chosen.
  virtual void begin_to_follow(const StabilityLimit& /*limit*/, CriticalModes /*modes*/) {}
  /// The length and the end of the next step of the plan.
  StepSpan planned_span() const;

 protected:
  explicit StepStrategy(RunData& run) : run_(run) {}

  /// The first step as the settings give it, s.
  virtual double first_step(const StabilityLimit& limit) const;
  /// The size of a first step as the stability limit allows it, s.
  virtual double stable_step(double step, const StabilityLimit& /*limit*/) const { return step; }

  // Helpers of several strategies.
  const TimeSettings& time() const { return run_.settings.time; }
  /// A rule that goes on where steps of the present one fail or add energy, as the end of an advice.
  std::string other_rule() const;

  RunData& run_;
};

/// The strategy of the present settings of a motion.
std::unique_ptr<StepStrategy> make_step_strategy(RunData& run);

/// The strategies of steps that do not adapt, one file each. The last one makes a step again, in smaller
/// ones, where those of `steps` fail (time.retry).
std::unique_ptr<StepStrategy> make_fixed_steps(RunData& run);
std::unique_ptr<StepStrategy> make_automatic_steps(RunData& run);
std::unique_ptr<StepStrategy> make_retried_steps(RunData& run, std::unique_ptr<StepStrategy> steps);

/// Looks at a step that has been entered in the balance. It refuses the step by setting the status and the
/// message of the outcome. `error_before`: the energy error before the step, J.
using StepCheck = std::function<void(StepOutcome&, double error_before)>;

/// Makes a step of the rule from one state to another, enters it in the balance, and checks it: that all
/// energies are finite, that it adds no energy where time.retry forbids this, and `check`. After a step that
/// failed or was refused the balance is as before. `to` does not become the present state.
StepOutcome attempt(RunData& run, const State& from, State& to, const StepSpan& span,
                    const StepCheck& check = {});
/// Makes the present state that after a step of this span, which begins at the present state, if the step succeeds.
StepOutcome attempt_and_accept(RunData& run, const StepSpan& span, const StepCheck& check = {});
/// Whether a smaller step may succeed where one with this outcome failed.
bool was_too_large(StepStatus status);

/// Takes back what was entered in the balance, unless it is released.
inline auto balance_guard(Balance& balance) {
  return ScopeExit([&balance, before = balance.sums()] { balance.restore(before); });
}

/// Counts the solver's iterations from its construction on, and reports all of them as those of one step.
class IterationCount {
 public:
  explicit IterationCount(RunProgress& progress);
  void report() const;

 private:
  RunProgress& progress_;
  Index iterations_;
  Index factorizations_;
  Index cg_iterations_;
};

/// A warning that steps were repeated in smaller ones, or an empty text.
std::string retry_warning(const RunProgress& progress, Index step);

}  // namespace tetraction
