#include "energy_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetraction::viewer {
namespace {

constexpr double kLimit = 0.01;
// A single step may have a large error.
constexpr int kSteps = 25;

}  // namespace

void EnergyWatch::restart(const Session& session) {
  start_ = session.balance().energy_error();
  error_ = 0.0;
  limit_ = kLimit;
  steps_ = 0;
  kinetic_ = session.balance().energies().kinetic();
  exchange_ = 0.0;
}

void EnergyWatch::allow(const Session& session) {
  const double limit = 2.0 * limit_;
  restart(session);
  limit_ = limit;
}

bool EnergyWatch::exceeded(const Session& session) {
  error_ = session.balance().energy_error() - start_;
  entered_ = session.balance().energy_scale();
  const double kinetic = session.balance().energies().kinetic();
  if (steps_ == 0) exchange_ = 0.0;
  exchange_ = std::max(exchange_, std::abs(kinetic - std::exchange(kinetic_, kinetic)));
  // A body at rest moves by round-off, which is no error of the rule. A rule of first order is wrong by
  // half of the energy that changes its form in a step: after n steps of a fall this is 1/n of what entered.
  const double allowed =
      std::max({limit_ * entered_, session.balance().sums().round_off, exchange_});
  const bool loses = session.time_settings().integrator == Integrator::kBackwardEuler;
  const bool is_large = (loses ? error_ : std::abs(error_)) > allowed;
  steps_ = is_large ? steps_ + 1 : 0;
  return steps_ == kSteps;
}

}  // namespace tetraction::viewer
