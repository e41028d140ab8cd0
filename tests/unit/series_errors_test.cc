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

// Where a potential energy is zero does not matter, and the total energy is compared with what its parts exchange.
TEST(SeriesErrors, OfEnergies) {
  const auto wave = [](double zero, double amplitude) {
    return [=](double t) { return Vector::Constant(1, zero + amplitude * std::sin(t)).eval(); };
  };
  for (const double zero : {0.0, 1e6}) {
    const ProbeRecord reference = record(1000, 2.0, wave(zero, 2.0));
    EXPECT_NEAR(series_error(ErrorKind::kEnergy, record(1000, 2.0, wave(zero, 2.1)), reference),
                0.05, 1e-9);
  }
  const ProbeRecord constant = record(1000, 2.0, wave(4.0, 0.0));
  EXPECT_NEAR(series_error(ErrorKind::kEnergy, record(1000, 2.0, wave(4.1, 0.0)), constant), 0.025,
              1e-12);

  const auto track = [&](double total) {
    MotionTrack result;
    result.probes = {record(1000, 2.0, wave(0.0, 2.0)), record(1000, 2.0, wave(total, 0.0))};
    result.probes[0].name = "energy.kinetic_energy";
    result.probes[1].name = "energy.total_energy";
    return result;
  };
  EXPECT_NEAR(series_error({ErrorKind::kEnergy, "total_energy"}, track(4.1), track(4.0)), 0.05,
              1e-6);
  EXPECT_TRUE(
      std::isnan(series_error({ErrorKind::kEnergy, "elastic_energy"}, track(4.1), track(4.0))));
}

}  // namespace
}  // namespace tetraction
