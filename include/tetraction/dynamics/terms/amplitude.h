// Factors of loads and prescribed motions that change in time.
#pragma once

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// An interval of time, for example that of a step.
struct TimeSpan {
  double begin = 0.0;  ///< s
  double end = 0.0;    ///< s

  double length() const { return end - begin; }
};

/// A factor a(t) with an exact integral. A default-constructed amplitude is 1 at all times.
class Amplitude {
 public:
  Amplitude() = default;
  /// Linear between points (time in s, value), constant before the first and after the last one.
  /// Throws InputError if there is no point, a number is not finite, or the times do not increase.
  static Amplitude piecewise_linear(std::vector<std::pair<double, double>> points);
  /// a(t) = offset + sin(2π f t + phase), with f = `frequency` in Hz and the phase in rad. Throws
  /// InputError for numbers that are not finite and for a frequency below zero.
  static Amplitude sine(double frequency, double phase, double offset);
  /// 0 until `from`, 1 after `until`, and between them s³(10 − 15 s + 6 s²) with
  /// s = (t − from)/(until − from), whose first and second derivatives are continuous. Throws
  /// InputError unless from < until and both are finite.
  static Amplitude smooth_step(double from, double until);

  /// a(t).
  double value(double time) const;
  /// da/dt, 1/s; at a corner the derivative on its right.
  double rate(double time) const;
  /// ∫ a dt over the interval, s. Exact up to round-off; 0 for an interval of length 0.
  double integral(const TimeSpan& span) const;
  /// The mean over the interval; of an interval of length 0 the value.
  double mean(const TimeSpan& span) const;

  bool operator==(const Amplitude&) const = default;

 private:
  enum class Kind { kConstant, kPoints, kSine, kSmoothStep };

  Kind kind_ = Kind::kConstant;
  std::vector<std::pair<double, double>> points_;
  double frequency_ = 0.0;
  double phase_ = 0.0;
  double offset_ = 0.0;
  double from_ = 0.0;
  double until_ = 0.0;
};

/// When a load acts, and with which factor.
struct LoadHistory {
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
  std::shared_ptr<const Amplitude> amplitude = nullptr;    ///< null: the factor 1

  /// The factor at a time: that of the amplitude for from ≤ t < until, and 0 otherwise.
  double value(double time) const;
  /// The mean of the factor over an interval, so that the length of the interval times the mean is
  /// the exact integral. `from` and `until` may lie inside the interval. Of an interval of length 0
  /// it is value().
  double mean(const TimeSpan& span) const;
};

}  // namespace tetraction
