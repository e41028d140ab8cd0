// Controls when the next step may begin, and measures how fast the run is.
#pragma once

#include <chrono>

namespace tetraction::viewer {

using Clock = std::chrono::steady_clock;

/// Delays steps so that simulated time does not run ahead of the wall clock, and measures the ratio
/// of the two.
class Pace {
 public:
  /// Limits the simulated seconds per second from now on. 0 means no limit.
  void set_limit(double real_time_factor, double simulated);
  double limit() const { return limit_; }
  /// To be called when the run begins or time has jumped. Delays before that are not made up for.
  void restart(double simulated);
  /// The wall-clock time at which the step from this simulated time may begin.
  Clock::time_point due(double simulated) const;
  /// To be called after each step.
  void advance(double simulated);
  /// Simulated seconds per second over about the last second of the run.
  double real_time_factor(double simulated) const;

 private:
  struct Anchor {
    Clock::time_point wall = Clock::now();
    double simulated = 0.0;
  };

  double limit_ = 0.0;
  Anchor anchor_;           // start of the count for the limit
  Anchor window_, newest_;  // starts of the present and the next measurement
};

}  // namespace tetraction::viewer
