#include "simulation/stepping/step_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tetraction {
namespace {

// The error of a step of size h is (h/best)^(order + 1), relative to the tolerance.
struct Course {
  double last = 0.0;
  int steps = 0;
  int rejected = 0;
};
Course settle(double first, double best, int order) {
  AdaptiveStepMemory memory;
  StepController controller(memory, order);
  Course course{first};
  bool was_rejected = false;
  for (int i = 0; i < 100; ++i) {
    const double error = std::pow(course.last / best, order + 1);
    if (error > 1.0) {
      ++course.rejected;
      was_rejected = true;
      course.last *= controller.after_rejection(error);
      continue;
    }
    const double factor = controller.after_success(error, was_rejected);
    was_rejected = false;
    ++course.steps;
    course.last *= factor;
    if (factor == 1.0 && course.steps > 20) break;
  }
  return course;
}

TEST(StepController, SettlesALittleBelowTheLargestStepThatTheToleranceAllows) {
  for (const int order : {1, 2}) {
    for (const double first : {1e-4, 0.5, 3.0, 1e4}) {
      const Course course = settle(first, 1.0, order);
      EXPECT_GT(course.last, 0.6) << order << " " << first;
      EXPECT_LT(course.last, 1.0) << order << " " << first;
      EXPECT_LE(course.rejected, first > 1.0 ? 7 : 0) << order << " " << first;
    }
  }
}

TEST(StepController, ChangesByAFactorOfFiveAtMostAndNeverGrowsAfterARejection) {
  AdaptiveStepMemory memory;
  StepController controller(memory, 2);
  EXPECT_EQ(controller.after_success(0.0, false), 5.0);
  EXPECT_EQ(controller.after_success(0.0, true), 1.0);
  EXPECT_EQ(controller.after_rejection(1e12), 0.2);
  EXPECT_EQ(controller.after_rejection(std::nan("")), 0.2);
  EXPECT_LE(controller.after_rejection(1.0 + 1e-12), 0.9);
  EXPECT_NEAR(controller.after_rejection(8.0), 0.45, 1e-12);
}

TEST(StepController, LeavesTheStepAsItIsIfItWouldHardlyGrow) {
  AdaptiveStepMemory memory;
  StepController controller(memory, 2);
  EXPECT_EQ(controller.after_success(0.6, false), 1.0);  // 0.9 · 0.6^(−1/3) = 1.07
  EXPECT_LT(controller.after_success(0.99, false), 1.0);
}

TEST(StepBounds, FollowFromTheFirstStepUnlessTheyAreGiven) {
  TimeSettings time;
  time.adapt = StepAdaptation::kError;
  EXPECT_DOUBLE_EQ(step_bounds(time, 2.0).least, 2e-6);
  EXPECT_DOUBLE_EQ(step_bounds(time, 2.0).most, 200.0);
  time.adapt = StepAdaptation::kEnergy;
  EXPECT_DOUBLE_EQ(step_bounds(time, 2.0).least, 0.2);
  EXPECT_DOUBLE_EQ(step_bounds(time, 2.0).most, 20.0);
  time.min_step = 0.5;
  time.max_step = 3.0;
  EXPECT_EQ(step_bounds(time, 2.0).least, 0.5);
  EXPECT_EQ(step_bounds(time, 2.0).most, 3.0);
}

class FindStep : public testing::Test {
 protected:
  // Counts the trials of a residual that is not defined above `defined`.
  StepRoot find(double at_zero, const std::function<double(double)>& residual,
                StepBounds bounds = {0.5, 2.0}, double defined = 1e9) {
    trials_.clear();
    return find_step(
        [&](double h) -> std::optional<double> {
          trials_.push_back(h);
          if (h > defined) return std::nullopt;
          return residual(h);
        },
        1.0, at_zero, bounds, 1e-12);
  }
  std::vector<double> trials_;
};

TEST_F(FindStep, TakesTwoTrialsWhereTheResidualIsLinearInTheSquare) {
  for (const double root : {0.6, 0.95, 1.05, 1.9}) {
    const auto residual = [&](double h) { return root * root - h * h; };
    const StepRoot found = find(residual(0.0), residual);
    EXPECT_TRUE(found.found) << root;
    EXPECT_NEAR(found.step, root, 1e-11);
    EXPECT_LE(trials_.size(), 3U) << root;
  }
}

TEST_F(FindStep, FindsTheRootOfOtherFunctions) {
  for (const double root : {0.7, 1.3, 1.9}) {
    for (const double fourth : {-0.05, 0.3, 2.0}) {
      const auto residual = [&](double h) {
        const auto f = [&](double x) { return x * x + fourth * std::pow(x, 4) + 0.1 * x * x * x; };
        return f(root) - f(h);
      };
      const StepRoot found = find(residual(0.0), residual);
      EXPECT_TRUE(found.found) << root << " " << fourth;
      EXPECT_NEAR(found.step, root, 1e-10);
      EXPECT_LE(trials_.size(), 10U) << root << " " << fourth;
    }
  }
}

TEST_F(FindStep, KeepsTheFirstStepIfItIsASolution) {
  const StepRoot found = find(0.0, [](double) { return 0.0; });
  EXPECT_TRUE(found.found);
  EXPECT_EQ(found.step, 1.0);
  EXPECT_EQ(trials_.size(), 1U);
}

// The residual has no zero between the bounds: above it everywhere, below, or only farther away.
TEST_F(FindStep, TakesTheLeastResidualIfThereIsNoSolution) {
  const auto grows = [](double h) { return 1.0 + h * h; };
  StepRoot found = find(1.0, grows);
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.step, 0.5);
  const auto farther = [](double h) { return 9.0 - h * h; };
  found = find(9.0, farther);
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.step, 2.0);
  EXPECT_DOUBLE_EQ(found.residual, 5.0);
  const auto nearer = [](double h) { return 0.01 - h * h; };
  found = find(0.01, nearer);
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.step, 0.5);
  EXPECT_LE(trials_.size(), 4U);
}

TEST_F(FindStep, LeavesOutStepsThatCannotBeMade) {
  const auto residual = [](double h) { return 0.49 - h * h; };
  StepRoot found = find(0.49, residual, {0.5, 2.0}, 0.8);
  EXPECT_TRUE(found.found);
  EXPECT_NEAR(found.step, 0.7, 1e-11);
  found = find(0.49, residual, {0.5, 2.0}, 0.1);
  EXPECT_EQ(found.step, 0.0) << "there is none";
  EXPECT_FALSE(found.found);
  // The larger one that would solve it cannot be made.
  found = find(
      2.25, [](double h) { return 2.25 - h * h; }, {0.5, 2.0}, 1.2);
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.step, 1.0);
}

}  // namespace
}  // namespace tetraction
