// A study that chooses its steps, on a real body.
#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

Scene swinging_block() {
  Scene scene = testing_support::spinning_block(Integrator::kMidpoint, 1e-3, 0.5);
  scene.initial.angular_velocity = Vector3::Zero();
  scene.initial.velocity = Vector3::Zero();
  return scene;
}

StudyRequests requests(const std::vector<std::string>& names,
                       const std::vector<std::string>& steps) {
  StudyRequests asked;
  for (const std::string& name : names) asked.rules.push_back(integrator_from_string(name));
  asked.steps = assign_steps(steps, asked.rules);
  asked.budget = 20.0;
  return asked;
}

struct Chosen {
  ChosenStudy study;
  StudyResult result;
  int trials = 0;
};

// Chooses the steps and makes the study; the trials are not made again.
Chosen make(const StudyRequests& asked) {
  const Scene scene = swinging_block();
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  const StudyPlan frame = begin_plan(scene, mesh, {});
  Chosen chosen;
  chosen.study = choose_study(frame, mesh, {}, asked, [&](const PlannedRun& run) {
    ++chosen.trials;
    return make_tracked_run(frame, run, mesh, {}, {}, {});
  });
  chosen.result = run_study(plan_study(scene, mesh, chosen.study.settings), mesh);
  return chosen;
}

TEST(ChosenStudy, BracketsTheErrorsOfEachRule) {
  const Chosen chosen = make(requests({"verlet", "midpoint"}, {}));
  for (const std::string& remark : chosen.study.choice.remarks) ADD_FAILURE() << remark;
  EXPECT_LE(chosen.trials, 30);
  double smallest = 1.0;
  double largest = 0.0;
  int runs = 0;
  for (const StudyRow& row : chosen.result.rows) {
    // Trials look for the limit of stability.
    if (row.role == StudyRole::kTrial) continue;
    EXPECT_EQ(row.status, RunStatus::kFinished) << row.directory << ": " << row.message;
    if (row.role != StudyRole::kRun || row.integrator != Integrator::kMidpoint) continue;
    ++runs;
    smallest = std::min(smallest, row.position_error);
    largest = std::max(largest, row.position_error);
  }
  EXPECT_GE(largest, 0.1);
  EXPECT_LE(smallest, 1e-3);
  EXPECT_GE(runs, 4);
  EXPECT_LE(chosen.result.reference_error, 3e-4);
}

TEST(ChosenStudy, MeetsATarget) {
  StudyRequests asked = requests({"verlet", "midpoint", "backward-euler"}, {});
  asked.target = 0.02;
  const Chosen chosen = make(asked);
  ASSERT_EQ(chosen.study.findings.size(), 3U);
  for (const RuleFinding& finding : chosen.study.findings) {
    bool has_run = false;
    for (const StudyRow& row : chosen.result.rows) {
      const double step = chosen.result.end / static_cast<double>(finding.target->n);
      if (row.integrator != finding.rule || std::abs(row.step - step) > 1e-9 * step) continue;
      has_run = true;
      EXPECT_EQ(row.role, StudyRole::kRun);
      EXPECT_LE(row.position_error + chosen.result.reference_error, 0.0201) << row.directory;
    }
    EXPECT_TRUE(has_run) << to_string(finding.rule);
  }
  EXPECT_EQ(chosen.study.choice.rules[1].target->outcome, TargetOutcome::kMet);
  EXPECT_LE(chosen.study.choice.rules[2].target->runs.size(), 8U);
}

TEST(ChosenStudy, TakesStepsInItsUnits) {
  const Chosen chosen =
      make(requests({"verlet", "midpoint"}, {"verlet=0.5x,auto", "midpoint=4x,0.02T"}));
  EXPECT_EQ(chosen.trials, 0);
  const double critical = chosen.result.stable_step;
  std::vector<double> steps;
  for (const StudyRow& row : chosen.result.rows) {
    if (row.role == StudyRole::kRun) steps.push_back(row.step / critical);
  }
  ASSERT_EQ(steps.size(), 3U);  // half of h_crit is what auto means
  EXPECT_NEAR(steps[0], 0.5, 0.02);
}

}  // namespace
}  // namespace tetraction
