// The energy of a contact layer: its formula, its derivatives, and its mean slope over a step.
#include "tetraction/dynamics/contact/barrier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tetraction {
namespace {

constexpr Barrier kLayer{0.02, 3.0e4};

// The formula of the header in extended precision.
long double exact_layer_energy(double d) {
  const long double r = static_cast<long double>(d) / kLayer.thickness;
  if (r >= 1.0L) return 0.0L;
  return -static_cast<long double>(kLayer.stiffness) * kLayer.thickness * (r - 1.0L) * (r - 1.0L) *
         std::log(r);
}

std::vector<double> layer_distances() {
  std::vector<double> all;
  for (const double r : {1e-6, 1e-3, 0.05, 0.3, 0.499, 0.501, 0.8, 0.99, 0.9999}) {
    all.push_back(r * kLayer.thickness);
  }
  return all;
}

TEST(Barrier, HasTheEnergyOfItsFormula) {
  for (const double d : layer_distances()) {
    const auto exact = static_cast<double>(exact_layer_energy(d));
    // r − 1 has the round-off of r.
    const double round_off = 1e-15 / (1.0 - d / kLayer.thickness);
    EXPECT_NEAR(kLayer.value(d), exact, (1e-14 + 2.0 * round_off) * exact) << d;
  }
}

TEST(Barrier, HasNoEnergyBeyondTheLayerAndInfiniteEnergyWhereItPenetrates) {
  for (const double d : {kLayer.thickness, 2.0 * kLayer.thickness, 1e9}) {
    EXPECT_EQ(kLayer.value(d), 0.0);
    EXPECT_EQ(kLayer.slope(d), 0.0);
    EXPECT_EQ(kLayer.curvature(d), 0.0);
  }
  EXPECT_EQ(kLayer.value(0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(kLayer.value(-1.0), std::numeric_limits<double>::infinity());
}

// Central differences of the formula with 19 digits: their error is (δ/d)²/3 of a derivative or so.
TEST(Barrier, HasTheDerivativesOfItsEnergy) {
  for (const double d : layer_distances()) {
    const double step = 1e-4 * std::min(d, kLayer.thickness - d);
    const long double ahead = exact_layer_energy(d + step);
    const long double behind = exact_layer_energy(d - step);
    const auto slope = static_cast<double>((ahead - behind) / (2.0L * step));
    EXPECT_NEAR(kLayer.slope(d), slope, 1e-7 * std::abs(slope)) << d;
    const double curvature = (kLayer.slope(d + step) - kLayer.slope(d - step)) / (2.0 * step);
    EXPECT_NEAR(kLayer.curvature(d), curvature, 1e-6 * curvature) << d;
    EXPECT_LT(kLayer.slope(d), 0.0);
    EXPECT_GT(kLayer.curvature(d), 0.0);
  }
}

// With r = 1 − s and small s: U = κ d̂ s³, −U′ = 3 κ s², U″ = 6 κ s/d̂, each up to a part of the order of s.
TEST(Barrier, LeavesTheLayerWithTwoContinuousDerivatives) {
  for (const double s : {1e-2, 1e-4, 1e-6}) {
    const double d = (1.0 - s) * kLayer.thickness;
    EXPECT_NEAR(kLayer.value(d) / (kLayer.stiffness * kLayer.thickness * s * s * s), 1.0,
                2.0 * s + 1e-9);
    EXPECT_NEAR(-kLayer.slope(d) / (3.0 * kLayer.stiffness * s * s), 1.0, 3.0 * s + 1e-9);
    EXPECT_NEAR(kLayer.curvature(d) * kLayer.thickness / (6.0 * kLayer.stiffness * s), 1.0,
                4.0 * s + 1e-9);
  }
}

std::vector<double> distances_around_the_layer() {
  std::vector<double> all = layer_distances();
  for (const double r : {1.0, 1.0001, 1.3, 40.0}) all.push_back(r * kLayer.thickness);
  return all;
}

TEST(Barrier, HasTheMeanSlopeBetweenTwoDistances) {
  for (const double a : distances_around_the_layer()) {
    for (const double b : distances_around_the_layer()) {
      if (a == b) continue;
      const long double difference = exact_layer_energy(b) - exact_layer_energy(a);
      const auto mean = static_cast<double>(difference / (static_cast<long double>(b) - a));
      EXPECT_NEAR(kLayer.mean_slope(a, b), mean, 1e-12 * std::abs(mean)) << a << ", " << b;
      EXPECT_EQ(kLayer.mean_slope(a, b), kLayer.mean_slope(a, b));
      EXPECT_NEAR(kLayer.mean_slope(a, b), kLayer.mean_slope(b, a), 1e-13 * std::abs(mean));
    }
  }
}

// The mean over a short way from a to b is U′ in its middle, up to (b − a)²/24 U‴. The quotient of differences
// would have lost all digits.
TEST(Barrier, HasTheMeanSlopeOfDistancesThatAreNearlyEqual) {
  for (const double a : layer_distances()) {
    EXPECT_EQ(kLayer.mean_slope(a, a), kLayer.slope(a));
    for (const double relative : {1e-7, -1e-7, 1e-12, 1e-15}) {
      const double b = a * (1.0 + relative);
      if (b >= kLayer.thickness) continue;
      const double middle = kLayer.slope(a + 0.5 * (b - a));
      const double part = 1e-4 * a;
      const double third = (kLayer.curvature(a - part) - kLayer.curvature(a)) / part;
      const double tolerance = 2e-12 * std::abs(middle) + (b - a) * (b - a) / 20.0 * third;
      EXPECT_NEAR(kLayer.mean_slope(a, b), middle, tolerance) << a << ", " << b;
    }
  }
}

// m(a, b) = (U(b) − U(a))/(b − a) has the derivative (U′(b) − m)/(b − a).
TEST(Barrier, HasTheDerivativeOfTheMeanSlope) {
  for (const double a : distances_around_the_layer()) {
    for (const double b : distances_around_the_layer()) {
      const double rate = kLayer.mean_slope_rate(a, b);
      EXPECT_GE(rate, 0.0);
      double step = 1e-4 * std::min(a, b);
      if (a != b) step = std::min(step, 1e-3 * std::abs(a - b));
      if (b != kLayer.thickness) step = std::min(step, 1e-3 * std::abs(b - kLayer.thickness));
      const double difference =
          (kLayer.mean_slope(a, b + step) - kLayer.mean_slope(a, b - step)) / (2.0 * step);
      // Round-off of the differences, and their curvature where U″ has a corner.
      const double tolerance = 1e-5 * std::abs(difference) +
                               1e-14 * std::abs(kLayer.mean_slope(a, b)) / step +
                               (b == kLayer.thickness ? kLayer.curvature(b - step) : 0.0);
      EXPECT_NEAR(rate, difference, tolerance) << a << ", " << b;
    }
  }
}

TEST(Barrier, HasHalfOfTheCurvatureAsTheRateWhereNothingMoves) {
  for (const double d : layer_distances()) {
    EXPECT_EQ(kLayer.mean_slope_rate(d, d), 0.5 * kLayer.curvature(d));
    const double near = kLayer.mean_slope_rate(d, d * (1.0 - 1e-9));
    EXPECT_NEAR(near, 0.5 * kLayer.curvature(d), 1e-5 * kLayer.curvature(d)) << d;
  }
}

// Energy and pressure fall with the distance, so that each belongs to one.
TEST(Barrier, KnowsTheDistanceOfAnEnergyAndOfAPressure) {
  for (const double d : layer_distances()) {
    EXPECT_NEAR(kLayer.distance_at_energy(kLayer.value(d)), d, 1e-6 * d);
    EXPECT_NEAR(kLayer.distance_at_pressure(-kLayer.slope(d)), d, 1e-6 * d);
  }
  EXPECT_EQ(kLayer.distance_at_energy(0.0), kLayer.thickness);
  EXPECT_EQ(kLayer.distance_at_pressure(0.0), kLayer.thickness);
}

}  // namespace
}  // namespace tetraction
