#include "simulation/stepping/automatic_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace tetraction {
namespace {

constexpr double kCost = 15.0;  // of an estimate, in steps

struct Course {
  double time_step = 0.5;
  double smallest = 0.5;
  double largest = 0.5;
  double largest_share = 0.0;  // of the limit
  double largest_growth = 1.0;
  Index estimates = 0;
  Index changes = 0;
};

Course follow(const std::function<double(Index)>& limit, Index steps) {
  AutomaticStepMemory memory;
  AutomaticStep automatic(memory);
  automatic.start(limit(0), {}, 0);
  Course course;
  course.time_step = AutomaticStep::kShare * limit(0);
  for (Index step = 1; step <= steps; ++step) {
    if (automatic.is_due(step)) {
      ++course.estimates;
      const double next = automatic.enter(limit(step), kCost, step, course.time_step);
      if (next != course.time_step) ++course.changes;
      course.largest_growth = std::max(course.largest_growth, next / course.time_step);
      course.time_step = next;
    }
    course.smallest = std::min(course.smallest, course.time_step);
    course.largest = std::max(course.largest, course.time_step);
    course.largest_share = std::max(course.largest_share, course.time_step / limit(step));
  }
  return course;
}

TEST(AutomaticStep, StaysTheSameAndCostsLittleWhereTheLimitStays) {
  const Course course = follow([](Index) { return 1.0; }, 20000);
  EXPECT_EQ(course.changes, 0);
  EXPECT_LT(static_cast<double>(course.estimates) * kCost, 0.03 * 20000);
}

TEST(AutomaticStep, StaysTheSameWhereABodySwings) {
  const Course course =
      follow([](Index k) { return 1.0 + 0.08 * std::sin(0.01 * static_cast<double>(k)); }, 20000);
  EXPECT_EQ(course.changes, 0);
  EXPECT_LT(course.largest_share, 0.55);
  EXPECT_LT(static_cast<double>(course.estimates) * kCost, 0.03 * 20000);
}

TEST(AutomaticStep, SettlesAtTheLowestLimitOfALargeSwing) {
  const Course course =
      follow([](Index k) { return 1.0 + 0.4 * std::sin(0.002 * static_cast<double>(k)); }, 50000);
  EXPECT_LT(course.largest_share, 0.8);
  EXPECT_LT(course.largest_growth, 1.0201);
}

TEST(AutomaticStep, IsNeverAboveALimitThatFallsFast) {
  for (const double rate : {0.001, 0.01, 0.03}) {
    const Course course =
        follow([=](Index k) { return std::exp(-rate * static_cast<double>(k)); }, 500);
    EXPECT_LT(course.largest_share, 0.9) << rate;
  }
}

TEST(AutomaticStep, BecomesSmallerAtOnceAndGrowsSlowly) {
  const auto dip = [](Index k) { return k > 1000 && k < 3000 ? 0.3 : 1.0; };
  const Course low = follow(dip, 2900);
  EXPECT_EQ(low.time_step, 0.15);
  EXPECT_EQ(low.changes, 1);
  const Course later = follow(dip, 100000);
  EXPECT_LT(later.largest_growth, 1.1001);
  EXPECT_GT(later.time_step, 0.47);
  EXPECT_LE(later.time_step, 0.5);
}

}  // namespace
}  // namespace tetraction
