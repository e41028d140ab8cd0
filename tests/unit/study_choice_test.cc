// The choice of a study's steps, with runs of a made-up oscillator.
#include "tetraction/simulation/study_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tetraction {
namespace {

// One vertex swings with the period 1 s for 2.3 s. The frequencies of rules have errors of their orders.
struct Oscillator {
  double seconds_per_step = 1e-5;
  int runs = 0;
  int stop_after = 1000;

  MakeTrackedRun make() {
    return [this](const StudyRule& asked, double step) {
      const Integrator rule = asked.integrator;
      ++runs;
      const double h = 2.0 * std::numbers::pi * step;
      const bool is_explicit = !is_implicit(rule);
      const double seconds = seconds_per_step * (is_explicit ? 0.1 : 1.0) * 2.3 / step;
      if (runs > stop_after) return TrackedRun{nullptr, 0.0, true};
      if (is_explicit && step > 1e-2) return TrackedRun{nullptr, seconds, false};
      const double size = order(rule) == 2 ? h * h / (is_explicit ? 24.0 : 12.0) : h;
      auto track = std::make_shared<MotionTrack>();
      track->end = 2.3;
      track->count = 100;
      track->rest = Vector::Zero(3);
      ProbeRecord tip{"tip", 3, {}, {}};
      for (int k = 1; k <= 100; ++k) {
        const double phase = 2.0 * std::numbers::pi * 0.023 * k / (1.0 + size);
        track->positions.emplace_back(Vector3(std::cos(phase) - 1.0, 0.0, std::sin(phase)));
        tip.times.push_back(0.023 * k);
        tip.values.insert(tip.values.end(), {std::cos(phase) - 1.0, 0.0, std::sin(phase)});
      }
      track->probes.push_back(tip);
      return TrackedRun{track, seconds, false};
    };
  }
};

RuleQuestion rule(Integrator integrator, const std::string& steps = {}) {
  RuleQuestion question;
  question.rule = integrator;
  question.stable_step = 1e-2;
  const std::vector<StepRequest> requests =
      steps.empty() ? std::vector<StepRequest>() : read_step_requests(steps);
  question.asked = resolve_steps(requests, integrator, 1e-2, {2.3, 1e-2, {}});
  return question;
}

StepQuestion question() {
  StepQuestion asked;
  asked.rules = {rule(Integrator::kVerlet), rule(Integrator::kMidpoint),
                 rule(Integrator::kBackwardEuler)};
  asked.references = {rule(Integrator::kVerlet), rule(Integrator::kMidpoint)};
  asked.end = 2.3;
  asked.period = 1.0;
  return asked;
}

TEST(StudyChoice, GivesEachRuleALadder) {
  Oscillator oscillator;
  StudyBudget budget(60.0);
  const StepQuestion asked = question();
  const MakeTrackedRun make = oscillator.make();
  const StepChoice choice = choose_steps(asked, budget, make);
  EXPECT_TRUE(choice.remarks.empty()) << choice.remarks.front();
  EXPECT_EQ(choice.reference, Integrator::kVerlet);
  EXPECT_LE(choice.reference_error, 1e-4);
  ASSERT_EQ(choice.rules.size(), 3U);
  const std::vector<double>& verlet = choice.rules[0].steps;
  EXPECT_LE(verlet.back(), 1e-2);
  EXPECT_GE(verlet.back(), 0.4e-2);
  const auto reference = make(choice.reference, choice.reference_step).track;
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
    const auto error = [&](double step) {
      return relative_error(*make(asked.rules[i].rule, step).track, *reference, {});
    };
    const std::vector<double>& steps = choice.rules[i].steps;
    EXPECT_GE(error(steps.back()), 0.1) << i;
    EXPECT_LE(error(steps[steps.size() - 2]), 0.11) << i;
    EXPECT_LE(error(steps.front()), 1e-3) << i;
    EXPECT_GE(error(steps[1]), 1e-3) << i;
    EXPECT_NEAR(2.3 / steps.front(), std::round(2.3 / steps.front()), 1e-9);
  }
  EXPECT_LE(oscillator.runs, 40);
}

TEST(StudyChoice, KeepsTheStepsThatWereAskedFor) {
  Oscillator oscillator;
  StudyBudget budget(60.0);
  StepQuestion asked = question();
  asked.rules = {rule(Integrator::kVerlet, "1e-3"), rule(Integrator::kMidpoint, "0.5,auto")};
  const StepChoice choice = choose_steps(asked, budget, oscillator.make());
  EXPECT_EQ(choice.rules[0].steps, std::vector<double>{1e-3});
  EXPECT_FALSE(choice.rules[0].trials.empty());  // of the reference
  EXPECT_EQ(choice.rules[1].steps.back(), 0.5);
  EXPECT_GT(choice.rules[1].steps.size(), 4U);
}

TEST(StudyChoice, IsTheSameAgain) {
  Oscillator oscillator;
  StudyBudget budget(0.02);
  StudyBudget again(0.02);
  const StepChoice first = choose_steps(question(), budget, oscillator.make());
  const StepChoice second = choose_steps(question(), again, oscillator.make());
  EXPECT_FALSE(first.remarks.empty());
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(first.rules[i].steps, second.rules[i].steps);
}

TEST(StudyChoice, MeetsATarget) {
  for (const char* measure : {"positions", "frequency.probe.tip", "probe.tip"}) {
    Oscillator oscillator;
    StudyBudget budget(60.0);
    StepQuestion asked = question();
    asked.target = 0.01;
    asked.error = read_error_measure(measure);
    const StepChoice choice = choose_steps(asked, budget, oscillator.make());
    EXPECT_EQ(choice.rules[0].target->outcome, TargetOutcome::kStability) << measure;
    for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
      EXPECT_EQ(choice.rules[i].target->outcome, TargetOutcome::kMet) << measure;
      EXPECT_LE(choice.rules[i].target->trial.error, 0.01) << measure;
      EXPECT_GE(choice.rules[i].target->trial.error, 0.008) << measure;
      EXPECT_LE(choice.rules[i].target->runs.size(), 8U) << measure;
    }
    EXPECT_LE(choice.reference_error, 0.0015) << measure;
  }
}

TEST(StudyChoice, SaysThatTheReferenceIsNotAccurate) {
  Oscillator oscillator{.seconds_per_step = 1.0};
  StudyBudget budget(10.0);
  const StepChoice choice = choose_steps(question(), budget, oscillator.make());
  ASSERT_FALSE(choice.remarks.empty());
  EXPECT_NE(choice.remarks.front().find("the reference has an error of its own"), std::string::npos)
      << choice.remarks.front();
  int ladders = 0;
  for (const RuleChoice& rule : choice.rules) ladders += rule.steps.size() > 1 ? 1 : 0;
  EXPECT_GE(ladders, 2);
}

TEST(StudyChoice, MeasuresTheLargestStableStep) {
  // The runs with steps up to 0.01 s reach the end, which is h_crit, or a little less or more than that.
  for (const double critical : {0.95e-2, 1e-2, 1.3e-2}) {
    Oscillator oscillator;
    StudyBudget budget(60.0);
    StepQuestion asked = question();
    asked.rules[0].stable_step = critical;
    const StepChoice choice = choose_steps(asked, budget, oscillator.make());
    ASSERT_TRUE(choice.rules[0].stable);
    EXPECT_NEAR(2.3 / static_cast<double>(choice.rules[0].stable->stable), 1e-2, 3e-4) << critical;
    EXPECT_LE(choice.rules[0].stable->runs, 10);
    EXPECT_FALSE(choice.rules[1].stable);
  }
}

TEST(StudyChoice, StopsOnRequest) {
  Oscillator oscillator{.stop_after = 4};
  StudyBudget budget(60.0);
  const StepChoice choice = choose_steps(question(), budget, oscillator.make());
  EXPECT_TRUE(choice.is_stopped);
  EXPECT_EQ(oscillator.runs, 5);
}

TEST(StudyChoice, TakesTheReferenceThatWasAskedFor) {
  Oscillator oscillator;
  StudyBudget budget(60.0);
  StepQuestion asked = question();
  asked.references = {rule(Integrator::kMidpoint)};
  asked.reference_step = 1e-3;
  const StepChoice choice = choose_steps(asked, budget, oscillator.make());
  EXPECT_EQ(choice.reference, Integrator::kMidpoint);
  EXPECT_EQ(choice.reference_step, 1e-3);
}

// It does not reach for more accuracy with smaller first steps, and a rule with settings has a ladder of its own.
TEST(StudyChoice, MakesOneRunOfARuleThatAdaptsItsSteps) {
  Oscillator oscillator;
  StudyBudget budget(60.0);
  StepQuestion asked = question();
  asked.rules = {rule(Integrator::kMidpoint), rule(Integrator::kMidpoint),
                 rule(Integrator::kMidpoint)};
  asked.rules[1].rule.settings = {{"solver.tolerance", "1e-6"}};
  asked.rules[2].rule.settings = {{"time.adapt", "error"}};
  asked.rules[2].adapts = true;
  const StepChoice choice = choose_steps(asked, budget, oscillator.make());
  EXPECT_EQ(choice.rules[1].steps, choice.rules[0].steps);
  EXPECT_EQ(choice.rules[2].steps.size(), 1U);
  EXPECT_TRUE(choice.rules[2].trials.empty());
}

}  // namespace
}  // namespace tetraction
