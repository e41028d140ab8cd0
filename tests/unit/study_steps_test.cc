// Texts that ask for steps, errors and limits of a study.
#include "tetraction/simulation/study_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The message of an InputError, or an empty text without one.
std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

void expect_refusal(const std::function<void()>& call, const std::vector<std::string>& words) {
  const std::string message = refusal(call);
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), std::string::npos) << "no " << word << " in: " << message;
  }
}

constexpr Integrator kVerlet = Integrator::kVerlet;
constexpr Integrator kMidpoint = Integrator::kMidpoint;

StepScales scales() {
  return {1.0, 1e-3, [] { return 0.5; }};
}

ResolvedSteps resolve(const std::string& text, Integrator rule, double stable_step = 1e-3) {
  return resolve_steps(read_step_requests(text), rule, stable_step, scales());
}

TEST(StudySteps, AreReadInEveryUnit) {
  const std::vector<StepRequest> requests = read_step_requests("1e-3,2e-3s,4x,0.02T,auto");
  ASSERT_EQ(requests.size(), 5U);
  EXPECT_EQ(requests[0].unit, StepUnit::kSeconds);
  EXPECT_EQ(requests[0].value, 1e-3);
  EXPECT_EQ(requests[1].unit, StepUnit::kSeconds);
  EXPECT_EQ(requests[2].unit, StepUnit::kStableSteps);
  EXPECT_EQ(requests[2].value, 4.0);
  EXPECT_EQ(requests[3].unit, StepUnit::kPeriods);
  EXPECT_EQ(requests[3].value, 0.02);
  EXPECT_EQ(requests[4].unit, StepUnit::kAuto);
}

TEST(StudySteps, ThatAreMalformedAreRefused) {
  for (const char* text :
       {"", "1e-3,", "4y", "4 x", "x", "inf", "nan", "automatic", "0.1TT", "0x10", "0X1p-3s"}) {
    expect_refusal([&] { read_step_requests(text); }, {"is no step", "4x", "auto"});
  }
  expect_refusal([] { read_step_requests("-1e-3"); }, {"\"-1e-3\" is not positive"});
  expect_refusal([] { read_step_requests("0x"); }, {"is not positive"});
}

TEST(StudySteps, BelongToOneRuleOrToAll) {
  const std::vector<StudyRule> rules{kVerlet, kMidpoint, Integrator::kBackwardEuler};
  const auto assigned = assign_steps({"verlet=5e-6,auto", "1e-3", "backward-euler=2e-3,4x"}, rules);
  ASSERT_EQ(assigned.size(), 3U);
  EXPECT_EQ(assigned[0].size(), 3U);
  EXPECT_EQ(assigned[1].size(), 1U);
  ASSERT_EQ(assigned[2].size(), 3U);
  EXPECT_EQ(assigned[2][0].value, 2e-3);
  expect_refusal([&] { assign_steps({"verlett=1e-3"}, rules); },
                 {"\"verlett\" is no rule of this study", "did you mean verlet?"});
  expect_refusal([&] { assign_steps({"explicit=1e-3"}, rules); }, {"is no rule of this study"});
  expect_refusal([&] { assign_steps({"verlet=midpoint=1e-3"}, rules); }, {"is no step"});
  expect_refusal([&] { assign_steps({"=1e-3"}, rules); }, {"the name of the rule is missing"});
}

TEST(StudySteps, NameTheirRules) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(rules_with_steps({"verlet=1e-5", "midpoint=1e-3", "verlet=2e-5"}),
            (Names{"verlet", "midpoint"}));
  EXPECT_EQ(rules_with_steps({"verlet=1e-5", "1e-3"}), Names());
  EXPECT_EQ(rules_with_steps({}), Names());
}

TEST(StudySteps, InOtherUnitsDivideTheEnd) {
  // 7 h_crit are 142.86 steps: one of 143 of them is a little shorter.
  const ResolvedSteps resolved = resolve("7x,1x,0.02T,1.5e-3", kMidpoint);
  EXPECT_FALSE(resolved.has_ladder);
  ASSERT_EQ(resolved.steps.size(), 4U);
  EXPECT_DOUBLE_EQ(resolved.steps[0], 1e-3);
  EXPECT_DOUBLE_EQ(resolved.steps[1], 1.5e-3);
  EXPECT_DOUBLE_EQ(resolved.steps[2], 1.0 / 143.0);
  EXPECT_DOUBLE_EQ(resolved.steps[3], 1e-2);
}

TEST(StudySteps, AreThereOnce) {
  EXPECT_EQ(resolve("1x,1e-3,2e-3,2x,0.001", kVerlet).steps.size(), 2U);
}

TEST(StudySteps, AutoIsHalfTheLimitOrTheLadder) {
  const ResolvedSteps verlet = resolve("auto", kVerlet, 8e-4);
  ASSERT_EQ(verlet.steps.size(), 1U);
  EXPECT_DOUBLE_EQ(verlet.steps[0], 4e-4);
  EXPECT_FALSE(verlet.has_ladder);
  const ResolvedSteps midpoint = resolve("auto,1e-2", kMidpoint);
  EXPECT_EQ(midpoint.steps.size(), 1U);
  EXPECT_TRUE(midpoint.has_ladder);
  EXPECT_TRUE(resolve_steps({}, kVerlet, 1e-3, scales()).has_ladder);
  // A short study is one step.
  EXPECT_EQ(resolve("auto", kVerlet, 100.0).steps, std::vector<double>{1.0});
}

TEST(StudySteps, ThatDoNotFitTheSceneAreRefused) {
  expect_refusal([] { resolve("2", kMidpoint); },
                 {"The step 2 s of midpoint", "at most the end time 1 s"});
  expect_refusal([] { resolve("4000x", kMidpoint); },
                 {"The step 4000x of midpoint, which is 4 s,", "at most the end time 1 s"});
  expect_refusal([] { resolve("1e-30", kMidpoint); }, {"than can be counted"});
  StepScales rigid = scales();
  rigid.stable_step = std::numeric_limits<double>::infinity();
  expect_refusal([&] { resolve_steps(read_step_requests("4x"), kVerlet, 1e-3, rigid); },
                 {"4x of verlet needs h_crit", "Give the step in s"});
}

TEST(ErrorMeasure, IsReadAndWritten) {
  for (const char* text : {"positions", "probe.tip", "peak.probe.tip", "frequency.probe.tip_x",
                           "energy.total_energy"}) {
    EXPECT_EQ(to_string(read_error_measure(text)), text);
  }
  EXPECT_EQ(read_error_measure("").kind, ErrorKind::kPositions);
  EXPECT_EQ(read_error_measure("position").kind, ErrorKind::kPositions);
  EXPECT_EQ(read_error_measure("peak.probe.tip").name, "tip");
  for (const char* text : {"probe.", "tip", "peak.tip", "energy."}) {
    expect_refusal([&] { read_error_measure(text); }, {"--error", "peak.probe.NAME"});
  }
}

TEST(StudyLimits, AreRead) {
  EXPECT_EQ(read_duration("10s", "--budget"), 10.0);
  EXPECT_EQ(read_duration("2min", "--budget"), 120.0);
  EXPECT_EQ(read_duration("0.5h", "--budget"), 1800.0);
  for (const char* text : {"10", "", "-1s", "0s", "3d", "s", "1min 2"}) {
    expect_refusal([&] { read_duration(text, "--budget"); }, {"--budget", "10s, 2min or 1h"});
  }
  EXPECT_DOUBLE_EQ(read_share("1%", "--target"), 0.01);
  EXPECT_DOUBLE_EQ(read_share("0.02", "--target"), 0.02);
  for (const char* text : {"0%", "100%", "1", "-1%", "one", "1%%"}) {
    expect_refusal([&] { read_share(text, "--target"); }, {"--target", "1% or 0.01"});
  }
}

TEST(StepSeries, IsOneTwoFive) {
  EXPECT_EQ(series_above(0.1), 1);
  EXPECT_EQ(series_above(3.0), 5);
  EXPECT_EQ(series_above(5.0), 5);
  EXPECT_EQ(series_above(51.0), 100);
  EXPECT_EQ(series_below(1.0), 1);
  EXPECT_EQ(series_below(3.0), 2);
  EXPECT_EQ(series_below(10.0), 10);
  EXPECT_EQ(series_below(999.0), 500);
  EXPECT_EQ(series_above(std::nan("")), 1);
  EXPECT_GT(series_above(1e300), Index{8000000000000000});
}

TEST(StudyRules, HaveSettingsInAnyOrder) {
  const StudyRule rule = read_study_rule("midpoint:time.tolerance=1e-3,time.adapt=error");
  EXPECT_EQ(to_string(rule), "midpoint:time.adapt=error,time.tolerance=1e-3");
  EXPECT_EQ(to_string(rule.settings), "time.adapt=error, time.tolerance=1e-3");
  expect_refusal([] { read_study_rule("midpoint:solver.tolerance"); }, {"KEY=VALUE"});
  expect_refusal([] { read_study_rule("midpoint:output.every=2"); }, {"--vary output.every"});
}

TEST(StudyRules, TakeTheStepsOfTheirIntegratorOrTheirOwn) {
  const std::vector<StudyRule> rules{kMidpoint, read_study_rule("midpoint:solver.tolerance=1e-6"),
                                     read_study_rule("midpoint:solver.tolerance=1e-4")};
  const auto assigned =
      assign_steps({"midpoint=1e-3,2e-3", "midpoint:solver.tolerance=1e-4=5e-3"}, rules);
  EXPECT_EQ(assigned[0].size(), 2U);
  EXPECT_EQ(assigned[1].size(), 2U);
  ASSERT_EQ(assigned[2].size(), 1U);
  EXPECT_EQ(assigned[2][0].value, 5e-3);
}

}  // namespace
}  // namespace tetraction
