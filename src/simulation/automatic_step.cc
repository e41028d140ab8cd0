#include "automatic_step.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetraction {
namespace {

// Steps from the beginning to the first estimate. Each interval is at most four times the one
// before.
constexpr Index kFirstInterval = 4;
constexpr Index kIntervalGrowth = 4;
constexpr Index kLongestInterval = 1024;
// The share of the cost of all steps that estimates may take.
constexpr double kBudget = 0.025;
// An estimate is due when the step is more than this share of the limit that is extrapolated with
// its rate of change.
constexpr double kLargestShare = 0.8;
// Ratios of step to limit at which the step is reduced, begins to grow, and stops growing.
constexpr double kTooLarge = 1.1 * AutomaticStep::kShare;
constexpr double kTooSmall = 0.8 * AutomaticStep::kShare;
constexpr double kGrown = 0.96 * AutomaticStep::kShare;
constexpr double kGrowth = 1.02;
constexpr double kFastGrowth = 1.1;
// An instability multiplies the energy error by four or more in each step.
constexpr double kSuddenGrowth = 4.0;
constexpr double kNoticeable = 1e-8;  // of the energy that entered
constexpr double kForgetting = 0.999;
// Expected change of ln h_crit after which an estimate is due, but not sooner than after some steps.
constexpr double kExpectedChange = 0.05;
constexpr Index kLeastInterval = 8;

}  // namespace

AutomaticStep::AutomaticStep(double critical_step, CriticalModes modes, Index step)
    : modes_(std::move(modes)),
      critical_step_(critical_step),
      last_(step),
      next_(step + kFirstInterval),
      interval_(kFirstInterval) {}

double AutomaticStep::enter(double critical_step, double cost, Index step, double time_step) {
  const auto passed = static_cast<double>(std::max<Index>(1, step - last_));
  if (critical_step_ > 0.0 && std::isfinite(critical_step_) && std::isfinite(critical_step)) {
    // A limit that changed fast a moment ago may do so again.
    const double change = std::abs(std::log(critical_step / critical_step_));
    rate_ = std::max(0.5 * rate_, change / passed);
    if (elastic_energy_ > 0.0 && elastic_energy_at_estimate_ > 0.0) {
      constexpr double kLeast = 0.01;
      const double stored = std::abs(std::log(elastic_energy_ / elastic_energy_at_estimate_));
      sensitivity_ = std::max(0.5 * sensitivity_, change / std::max(kLeast, stored));
    }
  }
  critical_step_ = critical_step;
  recent_[known_ % kRemembered] = critical_step;
  ++known_;
  const double changed = changed_step(time_step);

  const double affordable = std::min(std::ceil(cost / kBudget), double{kLongestInterval});
  interval_ = std::min(kIntervalGrowth * interval_, static_cast<Index>(affordable));
  if (rate_ > 0.0) {
    const double margin = std::log(kLargestShare * critical_step / changed) / rate_;
    interval_ = static_cast<Index>(std::min(static_cast<double>(interval_), margin));
  }
  interval_ = std::max(kFirstInterval, interval_);
  last_ = step;
  next_ = step + interval_;
  elastic_energy_at_estimate_ = elastic_energy_;
  return changed;
}

void AutomaticStep::watch(double change, double scale, Index step) {
  change = std::abs(change);
  if (largest_change_ > 0.0 && change > kSuddenGrowth * largest_change_ &&
      change > kNoticeable * scale) {
    next_ = step;
  }
  largest_change_ = std::max(change, kForgetting * largest_change_);
}

void AutomaticStep::watch_elastic(double energy, Index step) {
  elastic_energy_ = energy;
  if (elastic_energy_at_estimate_ > 0.0 && energy > 0.0 && step >= last_ + kLeastInterval &&
      sensitivity_ * std::abs(std::log(energy / elastic_energy_at_estimate_)) > kExpectedChange) {
    next_ = step;
  }
}

double AutomaticStep::changed_step(double time_step) {
  if (time_step > kTooLarge * critical_step_) {
    grows_ = false;
    return kShare * critical_step_;
  }
  const double least = *std::min_element(recent_.begin(), recent_.end());
  if (known_ < kRemembered || !std::isfinite(least)) return time_step;
  if (time_step < kTooSmall * least) grows_ = true;
  if (time_step > kGrown * least) grows_ = false;
  if (!grows_) return time_step;
  const double growth = time_step < 0.5 * kShare * least ? kFastGrowth : kGrowth;
  return std::min(growth * time_step, kShare * least);
}

}  // namespace tetraction
