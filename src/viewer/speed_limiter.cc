#include "speed_limiter.h"

#include <algorithm>

namespace tetraction::viewer {
namespace {

using Seconds = std::chrono::duration<double>;

// If a run is late by more than this, it does not run faster afterwards to make up for it.
constexpr Seconds kLargestLag{0.1};
constexpr Seconds kWindow{0.5};  // length of a measurement

}  // namespace

void SpeedLimiter::set_limit(double real_time_factor, double simulated) {
  limit_ = real_time_factor > 0.0 ? real_time_factor : 0.0;
  anchor_ = {Clock::now(), simulated};
}

void SpeedLimiter::restart(double simulated) {
  anchor_ = window_ = newest_ = {Clock::now(), simulated};
}

Clock::time_point SpeedLimiter::due(double simulated) const {
  if (limit_ == 0.0) return anchor_.wall;
  // The wait is bounded, so that a very small limit does not overflow the clock.
  constexpr Seconds kLongest{3600.0};
  const Seconds wait = std::min(Seconds((simulated - anchor_.simulated) / limit_), kLongest);
  return anchor_.wall + std::chrono::duration_cast<Clock::duration>(wait);
}

void SpeedLimiter::advance(double simulated) {
  const Clock::time_point now = Clock::now();
  if (now - due(simulated) > kLargestLag) anchor_ = {now, simulated};
  if (now - newest_.wall > kWindow) {
    window_ = newest_;
    newest_ = {now, simulated};
  }
}

double SpeedLimiter::real_time_factor(double simulated) const {
  const double wall = Seconds(Clock::now() - window_.wall).count();
  return wall > 0.0 ? (simulated - window_.simulated) / wall : 0.0;
}

}  // namespace tetraction::viewer
