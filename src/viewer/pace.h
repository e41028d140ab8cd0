// When the next step may begin, and how fast the run is.
#pragma once

#include <chrono>

namespace tetraction::viewer {

using Clock = std::chrono::steady_clock;

/// Keeps simulated time from running ahead of the wall clock, and measures the ratio of the two.
class Pace {
 public:
  /// Simulated seconds a second from now on; 0: no limit.
  void set_limit(double real_time_factor, double simulated);
  double limit() const { return limit_; }
  /// The run begins, or time jumped: nothing is made up for.
  void restart(double simulated);
  /// When the step that starts at this simulated time may begin.
  Clock::time_point due(double simulated) const;
  /// A step was made.
  void advance(double simulated);
  /// Simulated seconds a second over about the last second of the run.
  double real_time_factor(double simulated) const;

 private:
  struct Anchor {
    Clock::time_point wall = Clock::now();
    double simulated = 0.0;
  };

  double limit_ = 0.0;
  Anchor anchor_;           // what the limit counts from
  Anchor window_, newest_;  // what the measured factor counts from, now and next
};

}  // namespace tetraction::viewer
