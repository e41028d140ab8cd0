// Amplitudes: values, rates, and exact integrals.
#include "tetraction/dynamics/terms/amplitude.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// ∫ a dt by the midpoint rule with many small intervals.
double quadrature(const Amplitude& amplitude, const TimeSpan& span) {
  constexpr int kParts = 20000;
  double sum = 0.0;
  for (int i = 0; i < kParts; ++i) {
    sum += amplitude.value(span.begin + (i + 0.5) / kParts * span.length());
  }
  return sum * span.length() / kParts;
}

Amplitude hat() {
  return Amplitude::piecewise_linear({{0.0, 0.0}, {2.5, 2.5}, {5.0, 0.0}});
}

TEST(Amplitude, IsOneByDefault) {
  const Amplitude one;
  EXPECT_EQ(one.value(-3.0), 1.0);
  EXPECT_EQ(one.rate(7.0), 0.0);
  EXPECT_EQ(one.integral({1.0, 3.5}), 2.5);
}

TEST(Amplitude, PointsAreJoinedByLinesAndHeldBeyondTheEnds) {
  const Amplitude amplitude = Amplitude::piecewise_linear({{1.0, 2.0}, {2.0, 4.0}, {4.0, 0.0}});
  EXPECT_EQ(amplitude.value(0.0), 2.0);
  EXPECT_EQ(amplitude.value(1.5), 3.0);
  EXPECT_EQ(amplitude.value(2.0), 4.0);
  EXPECT_EQ(amplitude.value(3.0), 2.0);
  EXPECT_EQ(amplitude.value(9.0), 0.0);
  EXPECT_EQ(amplitude.rate(0.5), 0.0);
  EXPECT_EQ(amplitude.rate(1.5), 2.0);
  EXPECT_EQ(amplitude.rate(2.0), -2.0);
  EXPECT_EQ(amplitude.rate(5.0), 0.0);
  EXPECT_DOUBLE_EQ(amplitude.integral({0.0, 5.0}), 2.0 + 3.0 + 4.0);
  EXPECT_DOUBLE_EQ(amplitude.integral({1.5, 3.0}), 0.5 * 3.5 + 3.0);
  EXPECT_DOUBLE_EQ(amplitude.integral({4.0, 5.0}), 0.0);
}

TEST(Amplitude, IntegralsAreExact) {
  const Amplitude sine = Amplitude::sine(3.0, 0.4, 0.7);
  const Amplitude step = Amplitude::smooth_step(0.5, 2.0);
  for (const TimeSpan span : {TimeSpan{0.0, 0.01}, TimeSpan{0.3, 1.7}, TimeSpan{1.9, 2.4},
                              TimeSpan{-1.0, 6.0}, TimeSpan{2.49, 2.52}}) {
    for (const Amplitude& amplitude : {hat(), sine, step}) {
      EXPECT_NEAR(amplitude.integral(span), quadrature(amplitude, span), 1e-6 * span.length());
    }
    const double omega = 6.0 * std::numbers::pi;
    EXPECT_NEAR(sine.integral(span),
                0.7 * span.length() +
                    (std::cos(omega * span.begin + 0.4) - std::cos(omega * span.end + 0.4)) / omega,
                1e-15 * (1.0 + span.length()));
  }
  EXPECT_NEAR(step.integral({0.5, 2.0}), 0.75, 1e-15);
  EXPECT_NEAR(step.integral({0.0, 4.0}), 2.75, 1e-15);
  // The integrals of many short intervals add up to that of the long one.
  for (const Amplitude& amplitude : {hat(), sine, step}) {
    double sum = 0.0;
    for (int k = 0; k < 7777; ++k) sum += amplitude.integral({k * 1e-3, (k + 1) * 1e-3});
    EXPECT_NEAR(sum, amplitude.integral({0.0, 7.777}), 1e-12 * 7.777);
  }
}

TEST(Amplitude, RatesAreDerivatives) {
  constexpr double kStep = 1e-6;
  for (const Amplitude& amplitude :
       {hat(), Amplitude::sine(3.0, 0.4, 0.7), Amplitude::smooth_step(0.5, 2.0)}) {
    for (const double time : {0.3, 0.7, 1.3, 1.99, 3.1, 6.0}) {
      const double difference =
          (amplitude.value(time + kStep) - amplitude.value(time - kStep)) / (2.0 * kStep);
      EXPECT_NEAR(amplitude.rate(time), difference, 1e-7);
    }
  }
}

TEST(Amplitude, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(Amplitude::piecewise_linear({}), InputError);
  EXPECT_THROW(Amplitude::piecewise_linear({{0.0, 1.0}, {0.0, 2.0}}), InputError);
  EXPECT_THROW(Amplitude::piecewise_linear({{0.0, std::nan("")}}), InputError);
  EXPECT_THROW(Amplitude::sine(-1.0, 0.0, 0.0), InputError);
  EXPECT_THROW(Amplitude::sine(INFINITY, 0.0, 0.0), InputError);
  EXPECT_THROW(Amplitude::smooth_step(1.0, 1.0), InputError);
}

TEST(LoadHistory, HasTheMeanOfItsFactorOverAnInterval) {
  LoadHistory history{1.0, 2.0, nullptr};
  EXPECT_EQ(history.value(0.99), 0.0);
  EXPECT_EQ(history.value(1.0), 1.0);
  EXPECT_EQ(history.value(2.0), 0.0);
  EXPECT_EQ(history.mean({0.0, 1.0}), 0.0);
  EXPECT_DOUBLE_EQ(history.mean({0.5, 1.5}), 0.5);
  EXPECT_DOUBLE_EQ(history.mean({0.0, 4.0}), 0.25);
  EXPECT_EQ(history.mean({1.2, 1.2}), 1.0);
  // Windows far shorter than the step keep all digits.
  EXPECT_DOUBLE_EQ((LoadHistory{9999.0, 9999.0 + 1e-6, nullptr}.mean({9998.5, 9999.2})),
                   ((9999.0 + 1e-6) - 9999.0) / (9999.2 - 9998.5));
  EXPECT_DOUBLE_EQ((LoadHistory{0.0, 1e-30, nullptr}.mean({0.0, 1e-3})), 1e-27);
  // The end of a step that is meant to be 0.7, and the next step.
  EXPECT_EQ((LoadHistory{0.3, 0.7, nullptr}.mean({0.6, 7 * 0.1})), 1.0);
  EXPECT_EQ((LoadHistory{0.3, 0.7, nullptr}.mean({0.1 * 7, 0.8})), 0.0);
  history.amplitude = std::make_shared<const Amplitude>(hat());
  EXPECT_DOUBLE_EQ(history.mean({0.0, 4.0}), 1.5 / 4.0);
  EXPECT_DOUBLE_EQ(history.mean({1.5, 3.0}), 0.5 * 1.75 / 1.5);
  EXPECT_EQ(history.value(1.5), 1.5);
}

}  // namespace
}  // namespace tetraction
