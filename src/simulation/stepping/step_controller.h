// The sizes of adaptive steps (time.adapt), without the body that moves.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include "tetraction/simulation/run_progress.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The smallest and the largest adaptive step, s.
struct StepBounds {
  double least = 0.0;
  double most = std::numeric_limits<double>::infinity();
};

/// The bounds of the settings, or those that follow from the first step, s, if they are absent.
StepBounds step_bounds(const TimeSettings& time, double first_step);

/// Chooses the size of the next step from the error of the last one, with the elementary controller
/// after a rejection and otherwise with a PI controller (Gustafsson 1991; Hairer & Wanner, Solving
/// Ordinary Differential Equations II, section IV.2). Errors are divided by the tolerance, so that a
/// step is accepted if its error is at most 1.
class StepController {
 public:
  /// `order` of the rule. Keeps a reference to `memory`.
  StepController(AdaptiveStepMemory& memory, int order)
      : memory_(memory), exponent_(1.0 / (order + 1)) {}

  /// The factor of the step after one that was rejected with this error, which need not be finite.
  double after_rejection(double error) const;
  /// The factor of the step after one that was accepted, perhaps after rejections. It is 1 if the
  /// step would hardly grow, so that a solver can keep what belongs to the size of the step.
  double after_success(double error, bool was_rejected);

 private:
  AdaptiveStepMemory& memory_;
  double exponent_;  // of the error of a step of a rule of order p: 1/(p + 1)
};

/// The size of a step at which a residual vanishes.
struct StepRoot {
  double step = 0.0;      ///< s; 0: the residual is not defined for any size that was tried
  double residual = 0.0;  ///< at this step
  bool found = false;     ///< whether |residual| is at most the tolerance
};

/// Searches for a step between the bounds where |residual(h)| ≤ tolerance, beginning at `first`.
/// The residual is nearly a linear function of h², with the value `at_zero` for h → 0. The search is
/// a secant method in h², and regula falsi (Illinois) once two steps have residuals of different
/// signs. `residual` returns nothing if the step cannot be made; larger ones are then left out, too.
/// If there is no solution, the result is the step with the least |residual| of those that were
/// tried, the two bounds among them.
StepRoot find_step(const std::function<std::optional<double>(double)>& residual, double first,
                   double at_zero, const StepBounds& bounds, double tolerance);

}  // namespace tetraction
