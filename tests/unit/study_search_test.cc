// Ladders, target steps and stable steps of studies, with made-up runs.
#include "tetraction/simulation/study_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

namespace tetraction {
namespace {

// A rule whose error is factor/n^order, and saturates where it is large. Runs with fewer steps than `stable` fail.
struct MadeUpRule {
  double factor = 1.0;
  double order = 2.0;
  Index stable = 1;
  double seconds_per_step = 1e-4;
  double noise = 0.0;  // relative, alternating with n

  Trial run(Index n) const {
    Trial trial;
    trial.seconds = seconds_per_step * static_cast<double>(n);
    trial.failed = n < stable;
    if (trial.failed) return trial;
    const double error = factor / std::pow(static_cast<double>(n), order);
    trial.error = error / (1.0 + 0.5 * error) * (1.0 + (n % 2 == 0 ? noise : -noise));
    return trial;
  }
};

// Makes runs of such rules and counts them.
struct Runs {
  std::vector<MadeUpRule> rules;
  std::vector<std::pair<std::size_t, Index>> made{};

  MeasureRun measure() {
    return [this](std::size_t rule, Index n) {
      made.emplace_back(rule, n);
      return rules[rule].run(n);
    };
  }
};

std::vector<Index> numbers(const Ladder& ladder) {
  std::vector<Index> n;
  for (const Rung& rung : ladder.rungs) n.push_back(rung.n);
  return n;
}

TEST(Ladder, BracketsErrorsFromTenToATenthOfAPerCent) {
  // Errors of about 10 % at n = 100, of 0.1 % at 1000.
  Runs runs{{{.factor = 1000.0}}};
  StudyBudget budget(60.0);
  const Ladder ladder =
      find_ladders({{.name = "midpoint", .first = 100}}, {}, budget, runs.measure()).front();
  EXPECT_EQ(numbers(ladder), (std::vector<Index>{50, 100, 200, 500, 1000}));
  EXPECT_GE(ladder.rungs.front().error, 0.1);
  EXPECT_LE(ladder.rungs[1].error, 0.1);
  EXPECT_LE(ladder.rungs.back().error, 1e-3);
  EXPECT_GT(ladder.rungs[ladder.rungs.size() - 2].error, 1e-3);
  EXPECT_TRUE(ladder.is_resolved);
  EXPECT_EQ(ladder.remark, "");
  EXPECT_LE(ladder.trials, 6);
  EXPECT_EQ(ladder.seconds_left(), 0.0);
}

TEST(Ladder, LeavesLongRunsToTheStudy) {
  // The step with an error of 0.1 % takes 20 s of the budget, which is no trial.
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 0.02}}};
  StudyBudget budget(60.0);
  const Ladder ladder =
      find_ladders({{.name = "midpoint", .first = 10}}, {}, budget, runs.measure()).front();
  EXPECT_TRUE(ladder.is_resolved);
  EXPECT_GE(ladder.rungs.back().n, 1000);
  EXPECT_LE(ladder.rungs.back().n, 2000);
  EXPECT_FALSE(ladder.rungs.back().is_made);
  EXPECT_LE(ladder.rungs.back().error, 1e-3);
  for (const auto& [rule, n] : runs.made) EXPECT_LE(runs.rules[rule].run(n).seconds, 0.03 * 60.0);
  EXPECT_TRUE(budget.allows(ladder.seconds_left()));
  EXPECT_LE(ladder.trials, 5);
}

TEST(Ladder, StartsFarFromTheErrorsOfInterest) {
  for (const Index first : {Index{1}, Index{100000}}) {
    Runs runs{{{.factor = 1000.0, .seconds_per_step = 1e-6}}};
    StudyBudget budget(60.0);
    const Ladder ladder =
        find_ladders({{.name = "midpoint", .first = first}}, {}, budget, runs.measure()).front();
    EXPECT_TRUE(ladder.is_resolved) << first;
    EXPECT_GE(ladder.rungs.front().error, 0.1) << first;
    EXPECT_LE(ladder.rungs[1].error, 0.1) << first;
    EXPECT_LE(ladder.trials, 10) << first;
  }
}

TEST(Ladder, OfAnExplicitRuleBeginsAtItsLimit) {
  // The error at the limit of 10,000 steps is 0.001 % already.
  Runs runs{{{.factor = 1000.0, .stable = 8000, .seconds_per_step = 1e-6}}};
  StudyBudget budget(60.0);
  const Ladder ladder =
      find_ladders({{.name = "verlet", .first = 8000, .fewest = 8000}}, {}, budget, runs.measure())
          .front();
  EXPECT_EQ(numbers(ladder), (std::vector<Index>{10000, 20000}));
  EXPECT_TRUE(ladder.is_resolved);
  EXPECT_EQ(ladder.trials, 1);
}

TEST(Ladder, PassesRunsThatFail) {
  // h_crit at the start is too optimistic: 30,000 steps are needed instead of 8,000.
  Runs runs{{{.factor = 1000.0, .stable = 30000, .seconds_per_step = 1e-6}}};
  StudyBudget budget(60.0);
  const Ladder ladder =
      find_ladders({{.name = "verlet", .first = 8000, .fewest = 8000}}, {}, budget, runs.measure())
          .front();
  EXPECT_EQ(numbers(ladder), (std::vector<Index>{50000, 100000}));
  EXPECT_EQ(ladder.trials, 3);
}

TEST(Ladder, IsCoarserWhereTheBudgetDoesNotReach) {
  // Of the first two rules two steps each are kept. The third, of first order, is too expensive.
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 1e-4},
             {.factor = 1000.0, .seconds_per_step = 1e-3},
             {.factor = 100.0, .order = 1.0, .seconds_per_step = 1e-3}}};
  StudyBudget budget(10.0);
  const std::vector<Ladder> ladders = find_ladders({{.name = "a", .first = 50},
                                                    {.name = "b", .first = 50},
                                                    {.name = "c", .order = 1, .first = 50}},
                                                   {}, budget, runs.measure());
  EXPECT_TRUE(ladders[0].is_resolved);
  EXPECT_TRUE(ladders[1].is_resolved);
  EXPECT_FALSE(ladders[2].is_resolved);
  EXPECT_NE(ladders[2].remark.find("c: not resolved within the budget of 10 s"), std::string::npos)
      << ladders[2].remark;
  double left = 0.0;
  for (const Ladder& ladder : ladders) left += ladder.seconds_left();
  EXPECT_TRUE(budget.allows(left));
  EXPECT_LE(runs.made.size(), 20U);
}

TEST(Ladder, KeepsTwoStepsOfTwoRulesWithoutAnyBudget) {
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 1.0},
             {.factor = 1000.0, .seconds_per_step = 2.0},
             {.factor = 1000.0, .seconds_per_step = 3.0}}};
  StudyBudget budget(1.0);
  const std::vector<Ladder> ladders =
      find_ladders({{.name = "a", .first = 50, .seconds_per_step = 1.0},
                    {.name = "b", .first = 50, .seconds_per_step = 2.0},
                    {.name = "c", .first = 50, .seconds_per_step = 3.0}},
                   {}, budget, runs.measure());
  EXPECT_EQ(numbers(ladders[0]), (std::vector<Index>{50, 100}));
  EXPECT_EQ(numbers(ladders[1]), (std::vector<Index>{50, 100}));
  EXPECT_EQ(numbers(ladders[2]), std::vector<Index>());
  EXPECT_EQ(runs.made.size(), 0U);
  EXPECT_DOUBLE_EQ(ladders[0].seconds_left(), 150.0);
}

TEST(Ladder, EndsForRulesThatNeverReachTheEnd) {
  Runs runs{{{.stable = 1000000000}}};
  StudyBudget budget(1e9);
  const Ladder ladder =
      find_ladders({{.name = "explicit", .order = 1}}, {}, budget, runs.measure()).front();
  EXPECT_EQ(ladder.trials, LadderSettings().most_trials);
  EXPECT_TRUE(ladder.rungs.empty());
  EXPECT_EQ(ladder.remark, "explicit: no trial run reached the end.");
}

// Differences of neighbouring runs of a rule, as find_reference() wants them.
MeasureRun differences(Runs& runs) {
  return [&runs](std::size_t rule, Index n) {
    bool has_half = false;
    for (const auto& [of, made] : runs.made) has_half = has_half || (of == rule && 2 * made == n);
    runs.made.emplace_back(rule, n);
    Trial trial = runs.rules[rule].run(n);
    trial.error = has_half ? runs.rules[rule].run(n / 2).error - trial.error : std::nan("");
    return trial;
  };
}

TEST(ChosenReference, HasTheErrorThatIsWanted) {
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 1e-5}}};
  StudyBudget budget(60.0);
  const ChosenReference found =
      find_reference({{.name = "midpoint", .first = 50}}, 1e-4, 0.4, budget, differences(runs));
  EXPECT_LE(found.error, 1e-4);
  EXPECT_NEAR(found.error, runs.rules[0].run(found.n).error, 0.05 * found.error);
  EXPECT_LE(found.n, 3 * 3163);
  EXPECT_LE(found.runs, 6);
  EXPECT_EQ(found.runs, static_cast<int>(runs.made.size()));
}

TEST(ChosenReference, PrefersTheFirstRuleThatIsCheap) {
  for (const double seconds_per_step : {1e-5, 1e-2}) {
    Runs runs{{{.factor = 1000.0, .stable = 10000, .seconds_per_step = seconds_per_step},
               {.factor = 1000.0, .seconds_per_step = 1e-3}}};
    StudyBudget budget(60.0);
    const ChosenReference found = find_reference(
        {{.name = "verlet", .first = 10000, .fewest = 10000, .seconds_per_step = seconds_per_step},
         {.name = "midpoint", .first = 50}},
        1e-4, 0.4, budget, differences(runs));
    EXPECT_EQ(found.rule, seconds_per_step < 1e-3 ? 0U : 1U);
    EXPECT_LE(found.error, 1e-4);
  }
}

TEST(ChosenReference, EndsWithItsShareOfTheBudget) {
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 0.01}}};
  StudyBudget budget(20.0);
  const ChosenReference found =
      find_reference({{.name = "midpoint", .first = 50}}, 1e-6, 0.4, budget, differences(runs));
  EXPECT_GT(found.error, 1e-6);
  EXPECT_LE(budget.spent(), 2.0 * 0.4 * 20.0);
  EXPECT_EQ(runs.made.back().second, found.n);
  EXPECT_EQ(2 * runs.made[runs.made.size() - 2].second, found.n);
}

TEST(ChosenReference, NeedsARunThatReachesTheEnd) {
  Runs runs{{{.stable = 1000000, .seconds_per_step = 0.1}}};
  StudyBudget budget(60.0);
  const ChosenReference found =
      find_reference({{.name = "verlet"}}, 1e-4, 0.4, budget, differences(runs));
  EXPECT_EQ(found.n, 0);
  EXPECT_TRUE(std::isnan(found.error));
  EXPECT_LE(found.runs, 8);
}

// The least n whose error is at most the target.
Index least_steps(const MadeUpRule& rule, double target) {
  Index n = 1;
  while (rule.run(n).failed || rule.run(n).error > target) ++n;
  return n;
}

TEST(TargetStep, IsTheLargestOneForOrdersOneTwoAndFour) {
  for (const double order : {1.0, 2.0, 4.0}) {
    for (const Index first : {3, 40, 1000}) {
      Runs runs{{{.factor = 2.0 * std::pow(10.0, order), .order = order}}};
      StudyBudget budget(1e9);
      const TargetStep found =
          find_target_step({.name = "rule", .order = static_cast<int>(order), .first = first}, 0,
                           0.01, budget, runs.measure());
      const Index least = least_steps(runs.rules[0], 0.01);
      EXPECT_EQ(found.outcome, TargetOutcome::kMet) << order << " " << first;
      EXPECT_LE(found.trial.error, 0.01);
      EXPECT_GE(found.n, least) << order << " " << first;
      EXPECT_LE(static_cast<double>(found.n), 1.006 * static_cast<double>(least))
          << order << " " << first;
      EXPECT_LE(runs.made.size(), 6U) << order << " " << first;
      EXPECT_EQ(runs.made.size(), found.runs.size());
      EXPECT_TRUE(found.is_monotone);
    }
  }
}

TEST(TargetStep, TakesThreeRunsWhereTheOrderHolds) {
  Runs runs{{{.factor = 1.0}}};
  StudyBudget budget(1e9);
  const TargetStep found =
      find_target_step({.name = "midpoint", .first = 40}, 0, 1e-5, budget, runs.measure());
  EXPECT_EQ(found.n, least_steps(runs.rules[0], 1e-5));
  EXPECT_LE(runs.made.size(), 3U);
}

TEST(TargetStep, IsFoundWithNoiseInEightRuns) {
  Runs runs{{{.factor = 100.0, .noise = 0.2}}};
  StudyBudget budget(1e9);
  const TargetStep found =
      find_target_step({.name = "midpoint", .first = 7}, 0, 0.01, budget, runs.measure());
  EXPECT_LE(runs.made.size(), 8U);
  EXPECT_LE(found.trial.error, 0.01);
  EXPECT_NEAR(static_cast<double>(found.n), 100.0, 12.0);
}

TEST(TargetStep, OfAStableRuleIsItsLimit) {
  Runs runs{{{.factor = 1.0, .stable = 900}}};
  StudyBudget budget(1e9);
  TargetStep found = find_target_step({.name = "verlet", .first = 900, .fewest = 900}, 0, 0.01,
                                      budget, runs.measure());
  EXPECT_EQ(found.outcome, TargetOutcome::kStability);
  EXPECT_EQ(found.n, 900);
  EXPECT_EQ(runs.made.size(), 1U);
  // The limit is not where h_crit says.
  runs = {{{.factor = 1.0, .stable = 1000}}};
  found = find_target_step({.name = "verlet", .first = 900, .fewest = 900}, 0, 0.01, budget,
                           runs.measure());
  EXPECT_EQ(found.outcome, TargetOutcome::kStability);
  EXPECT_GE(found.n, 1000);
  EXPECT_LE(found.n, 1020);
  EXPECT_LE(runs.made.size(), 8U);
}

TEST(TargetStep, MayNotBeMet) {
  // The error does not fall below 5 %.
  int runs = 0;
  StudyBudget budget(1e9);
  const TargetStep found =
      find_target_step({.name = "midpoint"}, 0, 0.01, budget, [&](std::size_t, Index n) {
        ++runs;
        return Trial{0.05 + 1.0 / static_cast<double>(n * n), 0.0, false};
      });
  EXPECT_EQ(found.outcome, TargetOutcome::kNotMet);
  EXPECT_EQ(found.n, 0);
  EXPECT_EQ(runs, 8);
  EXPECT_NEAR(found.trial.error, 0.05, 1e-3);
}

TEST(TargetStep, EndsWithTheBudgetAndWithoutErrors) {
  Runs runs{{{.factor = 1000.0, .seconds_per_step = 1.0}}};
  StudyBudget budget(100.0);
  const TargetStep found = find_target_step({.name = "midpoint"}, 0, 0.01, budget, runs.measure());
  EXPECT_EQ(found.outcome, TargetOutcome::kNoBudget);
  EXPECT_EQ(runs.made.size(), 1U);
  StudyBudget more(1e9);
  const TargetStep unknown = find_target_step({.name = "midpoint"}, 0, 0.01, more,
                                              [](std::size_t, Index) { return Trial{}; });
  EXPECT_EQ(unknown.outcome, TargetOutcome::kNoError);
  EXPECT_EQ(unknown.runs.size(), 8U);
}

TEST(TargetStep, SaysThatErrorsAreNotMonotone) {
  StudyBudget budget(1e9);
  const TargetStep found = find_target_step({.name = "midpoint", .first = 10}, 0, 0.01, budget,
                                            [](std::size_t, Index n) {
                                              const double x = static_cast<double>(n);
                                              return Trial{n == 10 ? 0.02 : 4.0 / x, 0.0, false};
                                            });
  EXPECT_FALSE(found.is_monotone);
  EXPECT_LE(found.trial.error, 0.01);
  EXPECT_LE(found.runs.size(), 8U);
}

TEST(StableStepSearch, FindsTheLimitByBisection) {
  for (const Index limit : {Index{500}, Index{1000}, Index{1003}, Index{1900}}) {
    StudyBudget budget(1e9);
    const StableStep found = find_stable_step(1000, 0.01, budget, [&](Index n) {
      return Trial{0.0, 1.0, n < limit};
    });
    EXPECT_GE(found.stable, limit);
    EXPECT_LT(found.unstable, limit);
    EXPECT_LE(static_cast<double>(found.stable), 1.0101 * static_cast<double>(found.unstable));
    EXPECT_LE(found.runs, 12) << limit;
  }
}

TEST(StableStepSearch, EndsWithTheBudgetAndAtOneStep) {
  StudyBudget budget(3.5);
  const auto run = [](Index n) { return Trial{0.0, static_cast<double>(n) / 1000.0, n < 700}; };
  const StableStep found = find_stable_step(1000, 1e-3, budget, run);
  EXPECT_GT(found.stable, 0);
  EXPECT_LE(budget.spent(), 3.5);
  StudyBudget more(1e9);
  const StableStep always = find_stable_step(20, 0.01, more, [](Index) { return Trial{}; });
  EXPECT_EQ(always.stable, 1);
  EXPECT_EQ(always.unstable, 0);
}

}  // namespace
}  // namespace tetraction
