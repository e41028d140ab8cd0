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

void AutomaticStep::start(double critical_step, CriticalModes modes, Index step) {
  memory_ = {};
  memory_.modes = std::move(modes);
  memory_.critical_step = critical_step;
  memory_.last = step;
  memory_.next = step + kFirstInterval;
  memory_.interval = kFirstInterval;
}

double AutomaticStep::enter(double critical_step, double cost, Index step, double time_step) {
  const auto passed = static_cast<double>(std::max<Index>(1, step - memory_.last));
  if (memory_.critical_step > 0.0 && std::isfinite(memory_.critical_step) &&
      std::isfinite(critical_step)) {
    // A limit that changed fast a moment ago may do so again.
    const double change = std::abs(std::log(critical_step / memory_.critical_step));
    memory_.rate = std::max(0.5 * memory_.rate, change / passed);
    if (memory_.elastic_energy > 0.0 && memory_.elastic_energy_at_estimate > 0.0) {
      constexpr double kLeast = 0.01;
      const double stored =
          std::abs(std::log(memory_.elastic_energy / memory_.elastic_energy_at_estimate));
      memory_.sensitivity = std::max(0.5 * memory_.sensitivity, change / std::max(kLeast, stored));
    }
  }
  memory_.critical_step = critical_step;
  memory_.recent[memory_.known % AutomaticStepMemory::kRemembered] = critical_step;
  ++memory_.known;
  const double changed = changed_step(time_step);

  const double affordable = std::min(std::ceil(cost / kBudget), double{kLongestInterval});
  memory_.interval = std::min(kIntervalGrowth * memory_.interval, static_cast<Index>(affordable));
  if (memory_.rate > 0.0) {
    const double margin = std::log(kLargestShare * critical_step / changed) / memory_.rate;
    memory_.interval = static_cast<Index>(std::min(static_cast<double>(memory_.interval), margin));
  }
  memory_.interval = std::max(kFirstInterval, memory_.interval);
  memory_.last = step;
  memory_.next = step + memory_.interval;
  memory_.elastic_energy_at_estimate = memory_.elastic_energy;
  return changed;
}

double AutomaticStep::least_recent() const {
  const std::size_t known = std::min(memory_.known, AutomaticStepMemory::kRemembered);
  double least = memory_.critical_step;
  for (std::size_t i = 0; i < known; ++i) least = std::min(least, memory_.recent[i]);
  return least;
}

void AutomaticStep::watch(double change, double scale, Index step) {
  change = std::abs(change);
  if (memory_.largest_change > 0.0 && change > kSuddenGrowth * memory_.largest_change &&
      change > kNoticeable * scale) {
    memory_.next = step;
  }
  memory_.largest_change = std::max(change, kForgetting * memory_.largest_change);
}

void AutomaticStep::watch_elastic(double energy, Index step) {
  memory_.elastic_energy = energy;
  if (memory_.elastic_energy_at_estimate > 0.0 && energy > 0.0 &&
      step >= memory_.last + kLeastInterval &&
      memory_.sensitivity * std::abs(std::log(energy / memory_.elastic_energy_at_estimate)) >
          kExpectedChange) {
    memory_.next = step;
  }
}

double AutomaticStep::changed_step(double time_step) {
  if (time_step > kTooLarge * memory_.critical_step) {
    memory_.grows = false;
    return kShare * memory_.critical_step;
  }
  const double least = *std::min_element(memory_.recent.begin(), memory_.recent.end());
  if (memory_.known < AutomaticStepMemory::kRemembered || !std::isfinite(least)) return time_step;
  if (time_step < kTooSmall * least) memory_.grows = true;
  if (time_step > kGrown * least) memory_.grows = false;
  if (!memory_.grows) return time_step;
  const double growth = time_step < 0.5 * kShare * least ? kFastGrowth : kGrowth;
  return std::min(growth * time_step, kShare * least);
}

}  // namespace tetraction
