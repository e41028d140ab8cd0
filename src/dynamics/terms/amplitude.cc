#include "tetraction/dynamics/terms/amplitude.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// A time, or the end of the interval that it is at except for round-off: the start k h of a step has
// round-off.
double snapped(double time, const TimeSpan& span) {
  const double round_off = 16.0 * std::numeric_limits<double>::epsilon() *
                           std::max(std::abs(span.begin), std::abs(span.end));
  if (std::abs(time - span.begin) <= round_off) return span.begin;
  if (std::abs(time - span.end) <= round_off) return span.end;
  return time;
}

// The value at `time` of the line through two points.
double on_line(const std::pair<double, double>& a, const std::pair<double, double>& b,
               double time) {
  const double s = (time - a.first) / (b.first - a.first);
  return (1.0 - s) * a.second + s * b.second;
}

}  // namespace

Amplitude Amplitude::piecewise_linear(std::vector<std::pair<double, double>> points) {
  if (points.empty()) throw InputError("An amplitude needs at least one point (time, value).");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [time, value] = points[i];
    if (!std::isfinite(time) || !std::isfinite(value)) {
      throw InputError(fmt::format("Point {} of an amplitude is not finite.", i));
    }
    if (i > 0 && !(time > points[i - 1].first)) {
      throw InputError(
          fmt::format("The times of an amplitude must increase, but point {} has {} s after {} s.",
                      i, time, points[i - 1].first));
    }
    if (i > 0 && !std::isfinite(value - points[i - 1].second)) {
      throw InputError(fmt::format(
          "Neighbouring values of an amplitude may differ by up to 1.8e308, but point {} has {} "
          "after {}.",
          i, value, points[i - 1].second));
    }
  }
  Amplitude amplitude;
  amplitude.kind_ = Kind::kPoints;
  amplitude.points_ = std::move(points);
  return amplitude;
}

Amplitude Amplitude::sine(double frequency, double phase, double offset) {
  if (!std::isfinite(frequency) || !std::isfinite(phase) || !std::isfinite(offset) ||
      frequency < 0.0) {
    throw InputError(
        "A sine needs a finite frequency of 0 or more, a finite phase and a finite offset.");
  }
  Amplitude amplitude;
  amplitude.kind_ = Kind::kSine;
  amplitude.frequency_ = frequency;
  amplitude.phase_ = phase;
  amplitude.offset_ = offset;
  return amplitude;
}

Amplitude Amplitude::smooth_step(double from, double until) {
  if (!std::isfinite(from) || !std::isfinite(until) || !(from < until)) {
    throw InputError(
        fmt::format("A smooth step needs from < until, not from {} s until {} s.", from, until));
  }
  Amplitude amplitude;
  amplitude.kind_ = Kind::kSmoothStep;
  amplitude.from_ = from;
  amplitude.until_ = until;
  return amplitude;
}

double Amplitude::value(double time) const {
  switch (kind_) {
    case Kind::kConstant:
      return 1.0;
    case Kind::kSine:
      return offset_ + std::sin(2.0 * std::numbers::pi * frequency_ * time + phase_);
    case Kind::kSmoothStep: {
      const double s = std::clamp((time - from_) / (until_ - from_), 0.0, 1.0);
      return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    }
    case Kind::kPoints:
      break;
  }
  const auto after = std::upper_bound(points_.begin(), points_.end(), time,
                                      [](double t, const auto& point) { return t < point.first; });
  if (after == points_.begin()) return after->second;
  if (after == points_.end()) return points_.back().second;
  return on_line(*(after - 1), *after, time);
}

double Amplitude::rate(double time) const {
  switch (kind_) {
    case Kind::kConstant:
      return 0.0;
    case Kind::kSine: {
      const double omega = 2.0 * std::numbers::pi * frequency_;
      return omega * std::cos(omega * time + phase_);
    }
    case Kind::kSmoothStep: {
      const double s = std::clamp((time - from_) / (until_ - from_), 0.0, 1.0);
      return 30.0 * s * s * (1.0 - s) * (1.0 - s) / (until_ - from_);
    }
    case Kind::kPoints:
      break;
  }
  const auto after = std::upper_bound(points_.begin(), points_.end(), time,
                                      [](double t, const auto& point) { return t < point.first; });
  if (after == points_.begin() || after == points_.end()) return 0.0;
  const auto before = after - 1;
  return (after->second - before->second) / (after->first - before->first);
}

double Amplitude::integral(const TimeSpan& span) const {
  if (!(span.end > span.begin)) return 0.0;
  switch (kind_) {
    case Kind::kConstant:
      return span.length();
    case Kind::kSine: {
      // The difference of two cosines as a product, which keeps its digits for short intervals.
      const double omega = 2.0 * std::numbers::pi * frequency_;
      const double half = 0.5 * omega * span.length();
      const double sinc = half == 0.0 ? 1.0 : std::sin(half) / half;
      const double middle = 0.5 * (span.begin + span.end);
      return span.length() * (offset_ + std::sin(omega * middle + phase_) * sinc);
    }
    case Kind::kSmoothStep: {
      // Gauss–Legendre quadrature with three points is exact for polynomials of degree 5.
      const TimeSpan rise{std::clamp(from_, span.begin, span.end),
                          std::clamp(until_, span.begin, span.end)};
      const double middle = 0.5 * (rise.begin + rise.end);
      const double arm = std::sqrt(0.6) * 0.5 * rise.length();
      const double mean =
          (5.0 * value(middle - arm) + 8.0 * value(middle) + 5.0 * value(middle + arm)) / 18.0;
      return rise.length() * mean + (span.end - rise.end);
    }
    case Kind::kPoints:
      break;
  }
  // The integrals between the corners, at which the interval is cut.
  double sum = 0.0;
  double time = span.begin;
  double value_there = value(time);
  auto next = std::upper_bound(points_.begin(), points_.end(), time,
                               [](double t, const auto& point) { return t < point.first; });
  for (; next != points_.end() && next->first < span.end; ++next) {
    sum += 0.5 * (value_there + next->second) * (next->first - time);
    time = next->first;
    value_there = next->second;
  }
  return sum + 0.5 * (value_there + value(span.end)) * (span.end - time);
}

double Amplitude::mean(const TimeSpan& span) const {
  return span.end > span.begin ? integral(span) / span.length() : value(span.begin);
}

double LoadHistory::value(double time) const {
  if (time < from || time >= until) return 0.0;
  return amplitude ? amplitude->value(time) : 1.0;
}

double LoadHistory::mean(const TimeSpan& span) const {
  if (!(span.end > span.begin)) return value(span.begin);
  double first = snapped(from, span);
  double last = snapped(until, span);
  if (first == last) {  // a window that is shorter than the round-off of the step's ends
    first = from;
    last = until;
  }
  const TimeSpan acting{std::max(first, span.begin), std::min(last, span.end)};
  if (!(acting.end > acting.begin)) return 0.0;
  return (amplitude ? amplitude->integral(acting) : acting.length()) / span.length();
}

}  // namespace tetraction
