#include "solver/linear/coarse_choice.h"

#include <gtest/gtest.h>

namespace tetraction {
namespace {

constexpr int kMany = 4 * static_cast<int>(CoarseChoice::kPrice);

// Solves of one decimal digit without a coarse space, until one is to be made.
int iterations_until_made(CoarseChoice& choice, int a_solve) {
  int total = 0;
  while (!choice.should_make(0) && total < 1000000) {
    choice.solved(a_solve, 1.0);
    total += a_solve;
  }
  return total;
}

TEST(CoarseChoice, MakesOneWhenItsPriceIsSpent) {
  CoarseChoice choice;
  EXPECT_FALSE(choice.should_make(0));
  EXPECT_FALSE(choice.should_make(static_cast<int>(CoarseChoice::kPrice)));
  EXPECT_TRUE(choice.should_make(static_cast<int>(CoarseChoice::kPrice) + 1));
  const int total = iterations_until_made(choice, 4);
  EXPECT_GT(total, CoarseChoice::kPrice);
  EXPECT_LE(total, CoarseChoice::kPrice + 4);
}

TEST(CoarseChoice, KeepsOneThatSparesIterations) {
  CoarseChoice choice;
  choice.made(true, kMany, 1.0);
  EXPECT_TRUE(choice.in_use());
  for (int i = 0; i < 1000; ++i) {
    choice.solved(10, 1.0);
    EXPECT_TRUE(choice.in_use());
    EXPECT_FALSE(choice.should_make(0));
  }
}

TEST(CoarseChoice, GivesUpOneThatDoesNotAndWaitsLonger) {
  CoarseChoice choice;
  int waited = 0;
  for (int i = 0; i < 3; ++i) {
    const int now = iterations_until_made(choice, 5);
    EXPECT_GT(now, 4 * waited);
    waited = now;
    choice.made(true, 0, 0.0);
    choice.solved(5, 1.0);
    EXPECT_FALSE(choice.in_use());
  }
}

TEST(CoarseChoice, GivesUpOneWithoutAFactor) {
  CoarseChoice choice;
  choice.made(false, kMany, 1.0);
  EXPECT_FALSE(choice.in_use());
  EXPECT_GT(iterations_until_made(choice, 5), 4 * CoarseChoice::kPrice);
}

TEST(CoarseChoice, RenewsOneThatHasBecomeStale) {
  CoarseChoice choice;
  choice.made(true, kMany, 1.0);
  choice.solved(10, 1.0);
  int extra = 0;
  while (!choice.should_make(0)) {
    choice.solved(20, 1.0);
    extra += 10;
    ASSERT_LT(extra, 1000);
  }
  EXPECT_GT(extra, CoarseChoice::kPrice);
  EXPECT_FALSE(choice.should_make(1));  // never in the middle of a solve
  choice.made(true, 0, 0.0);
  EXPECT_TRUE(choice.in_use());
  choice.solved(10, 1.0);
  EXPECT_FALSE(choice.should_make(0));
}

// Solves of next to no digits say nothing.
TEST(CoarseChoice, WaitsForASolveThatTells) {
  CoarseChoice choice;
  choice.made(true, kMany, 1.0);
  choice.solved(kMany, 0.01);
  EXPECT_TRUE(choice.in_use());
  choice.solved(kMany, 1.0);
  EXPECT_FALSE(choice.in_use());
}

}  // namespace
}  // namespace tetraction
