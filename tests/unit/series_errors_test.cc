// Errors of probes, their peaks and frequencies from values over time.
#include "simulation/study/series_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace tetraction {
namespace {

ProbeRecord record(int steps, double end, const std::function<Vector(double)>& value) {
  ProbeRecord result;
  result.name = "tip";
  for (int i = 0; i <= steps; ++i) {
    const double t = end * i / steps;
    const Vector values = value(t);
    result.width = static_cast<std::size_t>(values.size());
    result.times.push_back(t);
    result.values.insert(result.values.end(), values.begin(), values.end());
  }
  return result;
}

// Swings along y with this frequency and amplitude, and a little along the others.
std::function<Vector(double)> swing(double frequency, double amplitude) {
  return [=](double t) {
    const double phase = 2.0 * std::numbers::pi * frequency * t;
    return Vector(Vector3(0.01 * std::cos(3.0 * phase), amplitude * std::sin(phase), 0.0));
  };
}

TEST(SeriesErrors, OfPeaks) {
  const ProbeRecord reference = record(4000, 1.0, swing(5.0, 2.0));
  EXPECT_NEAR(series_error(ErrorKind::kPeak, record(1000, 1.0, swing(5.5, 2.1)), reference), 0.05,
              1e-3);
}

TEST(SeriesErrors, OfFrequencies) {
  const ProbeRecord reference = record(4000, 2.0, swing(5.0, 2.0));
  // The phase and the amplitude do not count.
  EXPECT_NEAR(series_error(ErrorKind::kFrequency, record(500, 2.0, swing(5.1, 1.0)), reference),
              0.02, 1e-3);
  const ProbeRecord constant = record(100, 2.0, [](double) { return Vector::Ones(3); });
  EXPECT_TRUE(std::isnan(series_error(ErrorKind::kFrequency, constant, reference)));
  EXPECT_TRUE(std::isnan(series_error(ErrorKind::kFrequency, reference, constant)));
}

TEST(SeriesErrors, OfProbesAreDifferencesOverTime) {
  const auto line = [](double slope) {
    return [=](double t) { return Vector(Vector::Constant(1, 4.0 + slope * t)); };
  };
  // The largest difference is 0.5 at the end, and the largest value 5. Linear values are exact between times.
  const ProbeRecord reference = record(7, 1.0, line(1.0));
  EXPECT_NEAR(series_error(ErrorKind::kProbe, record(10, 1.0, line(1.5)), reference), 0.1, 1e-14);
  EXPECT_NEAR(series_error(ErrorKind::kProbe, record(10, 1.0, line(1.0)), reference), 0.0, 1e-14);
}

TEST(SeriesErrors, AreUnknownWithoutValuesOrScale) {
  const ProbeRecord values = record(10, 1.0, swing(5.0, 1.0));
  const ProbeRecord zero = record(10, 1.0, [](double) { return Vector::Zero(3); });
  for (const ErrorKind kind : {ErrorKind::kProbe, ErrorKind::kPeak, ErrorKind::kFrequency}) {
    EXPECT_TRUE(std::isnan(series_error(kind, values, zero)));
    EXPECT_TRUE(std::isnan(series_error(kind, {}, values)));
    EXPECT_TRUE(std::isnan(series_error(kind, values, {})));
  }
}

}  // namespace
}  // namespace tetraction
