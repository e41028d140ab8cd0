// The methods that adapt steps (time.adapt).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "step_controller.h"
#include "step_strategy.h"

namespace tetraction {

/// An adaptation of steps: its strategy, and what the rest of the program says about it.
struct Adaptation {
  StepAdaptation name;
  std::unique_ptr<StepStrategy> (*make_strategy)(RunData& run);
  /// The smallest and the largest step over the first one, unless the settings say otherwise.
  double least_share;
  double most_share;
  /// A column of history.csv and its value.
  struct Column {
    const char* name;
    double StepControl::*value;
  };
  std::vector<Column> columns;
  /// The sentence about a finished run, after "step control: ".
  std::string (*report)(const StepControl& control, const TimeSettings& time);
  /// A warning about steps that did not meet what adapts them, or an empty text.
  std::string (*warning)(const StepControl& control, const TimeSettings& time, Index step);
};

/// All of them, in the order of the enumeration.
const std::vector<Adaptation>& adaptations();
/// The one of that name, which is not kNone.
const Adaptation& adaptation(StepAdaptation name);

/// Their descriptions, one in each file of strategies.
Adaptation adaptation_by_error();
Adaptation adaptation_by_energy();

/// Common parts of the strategies of steps that adapt: bounds, times at which steps must end, and a
/// share of the stability limit that explicit steps must not exceed.
class AdaptiveSteps : public StepStrategy {
 public:
  void renew(const StabilityLimit& limit, CriticalModes modes) override;
  std::optional<StepCollapse> follow_limit() override;
  void begin_to_follow(const StabilityLimit& limit, CriticalModes modes) override;

 protected:
  explicit AdaptiveSteps(RunData& run) : StepStrategy(run) {}

  double first_step(const StabilityLimit& limit) const override;
  double stable_step(double step, const StabilityLimit& limit) const override;
  /// energy_warning(), whose last sentence says what has to be smaller.
  std::string unresolved_warning(double share, const char* smaller) const;

  /// The bounds of steps at the present state, s.
  StepBounds bounds() const;
  /// The next time at which a step must end, s.
  double next_landing() const;
  /// The step of this length, or the one that ends exactly at the landing if the difference is
  /// negligible.
  StepSpan span_of(double length, double landing) const;
  /// The step that ends at the landing.
  StepSpan span_to(double landing) const { return {landing - run_.state().time, landing}; }

 private:
  // Adds a warning, once, if the stability limit needs steps smaller than time.min_step.
  void warn_of_smaller_steps();
};

}  // namespace tetraction
