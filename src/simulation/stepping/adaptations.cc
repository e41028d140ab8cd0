#include "adaptations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "automatic_step.h"
#include "limit_estimates.h"

namespace tetraction {
namespace {

// If less than this share of a step is left to a landing, the step is made a little longer.
constexpr double kMergedAtLanding = 1e-6;
// The largest share of the stability limit that an adaptive step may have. Its halves are then as
// long as the steps of "auto".
constexpr double kStableShare = 0.9;

}  // namespace

const std::vector<Adaptation>& adaptations() {
  static const std::vector<Adaptation> all{adaptation_by_error(), adaptation_by_energy()};
  return all;
}

const Adaptation& adaptation(StepAdaptation name) {
  return *std::ranges::find(adaptations(), name, &Adaptation::name);
}

StepBounds step_bounds(const TimeSettings& time, double first_step) {
  const Adaptation& kind = adaptation(time.adapt);
  return {time.min_step.value_or(kind.least_share * first_step),
          time.max_step.value_or(kind.most_share * first_step)};
}

double AdaptiveSteps::first_step(const StabilityLimit& limit) const {
  double step = StepStrategy::first_step(limit);
  if (time().min_step) step = std::max(step, *time().min_step);
  if (time().max_step) step = std::min(step, *time().max_step);
  return step;
}

double AdaptiveSteps::stable_step(double step, const StabilityLimit& limit) const {
  if (!follows_limit(time())) return step;
  return std::min(step, kStableShare * automatic_limit(run_, limit));
}

void AdaptiveSteps::begin_to_follow(const StabilityLimit& limit, CriticalModes modes) {
  if (!follows_limit(time())) return;
  start_to_follow(run_, automatic_limit(run_, limit), std::move(modes));
  warn_of_smaller_steps();
}

void AdaptiveSteps::renew(const StabilityLimit& limit, CriticalModes modes) {
  if (!follows_limit(time())) return;
  const double critical = automatic_limit(run_, limit);
  if (!std::isfinite(critical)) return;
  start_to_follow(run_, critical, std::move(modes));
  warn_of_smaller_steps();
}

std::optional<StepCollapse> AdaptiveSteps::follow_limit() {
  const AutomaticStep automatic(run_.progress.plan.automatic);
  if (!follows_limit(time()) || !automatic.is_due(run_.state().step)) return std::nullopt;
  enter_estimate(run_);  // bounds() uses it
  warn_of_smaller_steps();
  return std::nullopt;
}

StepBounds AdaptiveSteps::bounds() const {
  StepBounds bounds = step_bounds(time(), run_.progress.first_time_step);
  if (follows_limit(time())) {
    const double limit = limit_beside_obstacles(run_, run_.progress.plan.automatic.critical_step,
                                                run_.progress.plan.time_step);
    bounds.most = std::min(bounds.most, kStableShare * limit);
    bounds.least = std::min(bounds.least, bounds.most);
  }
  return bounds;
}

void AdaptiveSteps::warn_of_smaller_steps() {
  if (!time().min_step) return;
  if (*time().min_step <= kStableShare * run_.progress.plan.automatic.critical_step) return;
  std::string warning = fmt::format(
      "time.min_step = {:.4g} s is above {} of the stability limit of {}, or came to be so: the "
      "steps are smaller there, because longer ones would blow up. Take a smaller time.min_step, "
      "or an implicit integrator.",
      *time().min_step, kStableShare, to_string(time().integrator));
  std::vector<std::string>& warnings = run_.progress.warnings;
  if (std::ranges::find(warnings, warning) == warnings.end()) {
    warnings.push_back(std::move(warning));
  }
}

double AdaptiveSteps::next_landing() const {
  double next = time().end;
  const std::vector<EventSettings>& events = run_.scene.event;
  if (run_.progress.next_event < events.size()) {
    next = std::min(next, events[run_.progress.next_event].at);
  }
  return run_.landing > run_.state().time ? std::min(next, run_.landing) : next;
}

StepSpan AdaptiveSteps::span_of(double length, double landing) const {
  const StepSpan span{length, run_.state().time + length};
  if (!(std::abs(span.end - landing) <= kMergedAtLanding * length)) return span;
  const double left = landing - run_.state().time;
  return {std::abs(left - length) <= round_off_of_time(landing) ? length : left, landing};
}

std::string AdaptiveSteps::unresolved_warning(double share, const char* smaller) const {
  return fmt::format(
      "the energy error reached {:.3g} % of the energy that entered: the steps, down to {:.4g} s, "
      "do not resolve the motion. Take a smaller {}{}.",
      100.0 * share, run_.progress.steps.smallest, smaller, other_rule());
}

}  // namespace tetraction
