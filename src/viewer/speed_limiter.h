// Limits the speed of a run and measures it.
#pragma once

#include <chrono>

namespace tetraction::viewer {

using Clock = std::chrono::steady_clock;

/// Determines when the next step may begin, so that the ratio of simulated time to real time does not
/// exceed a limit. Also measures this ratio. `simulated` is the simulated time of the run, s.
class SpeedLimiter {
 public:
  /// Limits the simulated seconds per real second from now on. 0 means no limit.
  void set_limit(double real_time_factor, double simulated);
  double limit() const { return limit_; }
  /// Must be called when the run begins or the simulated time has jumped.
  void restart(double simulated);
  /// The time at which the step that begins at this simulated time may be made.
  Clock::time_point due(double simulated) const;
  /// Must be called after each step.
  void advance(double simulated);
  /// Simulated seconds per real second, measured over about the last second.
  double real_time_factor(double simulated) const;

 private:
  struct Anchor {
    Clock::time_point wall = Clock::now();
    double simulated = 0.0;
  };

  double limit_ = 0.0;
  Anchor anchor_;           // start of the interval to which the limit applies
  Anchor window_, newest_;  // starts of the present and of the next measurement
};

}  // namespace tetraction::viewer
