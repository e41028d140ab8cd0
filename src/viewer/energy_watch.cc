#include "energy_watch.h"

#include <algorithm>
#include <cmath>

namespace tetraction::viewer {
namespace {

constexpr double kLimit = 0.01;
// At the start of a motion little energy has entered, and the errors of single steps are large
// beside it.
constexpr int kSteps = 25;

}  // namespace

void EnergyWatch::restart(const Session& session) {
  start_ = session.balance().energy_error();
  error_ = 0.0;
  limit_ = kLimit;
  steps_ = 0;
}

void EnergyWatch::allow(const Session& session) {
  const double limit = 2.0 * limit_;
  restart(session);
  limit_ = limit;
}

bool EnergyWatch::exceeded(const Session& session) {
  error_ = session.balance().energy_error() - start_;
  entered_ = session.balance().energy_scale();
  // A body at rest moves by round-off, which is no error of the rule.
  const double allowed = std::max(limit_ * entered_, session.balance().sums().round_off);
  const bool loses = session.time_settings().integrator == Integrator::kBackwardEuler;
  const bool is_large = (loses ? error_ : std::abs(error_)) > allowed;
  steps_ = is_large ? steps_ + 1 : 0;
  return steps_ == kSteps;
}

}  // namespace tetraction::viewer
