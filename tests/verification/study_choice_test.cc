// Studies of real bodies: the choice of steps, and the error of the mesh.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

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

// The error of the mesh in a motion that is known.
constexpr double kYoungsModulus = 1.0e6;  // Pa
constexpr double kPoissonsRatio = 0.3;
constexpr double kDensity = 1000.0;  // kg/m³
constexpr double kSpeed = 1.0e-4;  // of the free end, m/s: strains of 1e-6, as in the linear theory
constexpr double kWidth = 0.5;     // m, of a bar with a length of 1 m
constexpr double kPeriods = 0.375;  // of the motion

// In its lowest mode sin(πx/2) the bar, which is held at x = 0 and cannot move sideways, has this angular frequency.
double frequency() {
  const double modulus = kYoungsModulus * (1.0 - kPoissonsRatio) /
                         ((1.0 + kPoissonsRatio) * (1.0 - 2.0 * kPoissonsRatio));
  return 0.5 * std::numbers::pi * std::sqrt(modulus / kDensity);
}
double end_time() {
  return 2.0 * std::numbers::pi * kPeriods / frequency();
}
double shape(double x) {
  return std::sin(0.5 * std::numbers::pi * x);
}

TetMesh with_velocity(TetMesh mesh) {
  Matrix& velocity = mesh.point_arrays["velocity"];
  velocity = Matrix::Zero(3, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    velocity(0, v) = kSpeed * shape(mesh.vertices[static_cast<std::size_t>(v)].x());
  }
  return mesh;
}

Scene bar() {
  Scene scene;
  scene.material.youngs_modulus = kYoungsModulus;
  scene.material.poissons_ratio = kPoissonsRatio;
  scene.material.density = kDensity;
  scene.time.end = end_time();
  scene.initial.velocity_array = "velocity";
  const auto hold = [&](int axis, double at) {
    FixSettings fix;
    fix.select = SelectPlane{axis, at, {}};
    fix.components = {axis == 0, axis == 1, axis == 2};
    scene.fix.push_back(fix);
  };
  hold(0, 0.0);
  for (const int side : {1, 2}) {
    for (const double at : {0.0, kWidth}) hold(side, at);
  }
  return scene;
}

struct Check {
  double difference = 0.0;  // of the mesh check
  double error = 0.0;       // |q - q_exact|/|q_exact - X| on the coarse mesh
};

Check check(const TetMesh& mesh) {
  const Scene scene = bar();
  StudySettings settings;
  settings.reference_integrator = Integrator::kVerlet;
  settings.rule_steps = {{Integrator::kVerlet, {0.4 * begin_plan(scene, mesh, {}).stable_step}}};
  const StudyPlan plan = plan_study(scene, mesh, settings);
  const auto fine_mesh =
      std::make_shared<const TetMesh>(with_velocity(mesh_of_mesh_check(plan, mesh)));
  const StudyPlan finer = mesh_check_plan(plan, fine_mesh);
  const PlannedRun& run = finer.runs.front();
  const MotionTrack coarse = *make_tracked_run(plan, run, mesh, {}, {}, {}).track;
  const MotionTrack fine = *make_tracked_run(finer, run, *fine_mesh, {}, {}, {}).track;
  Vector exact = Vector::Zero(coarse.rest.size());
  for (Index i = 0; i < exact.size(); i += 3) {
    exact[i] = kSpeed / frequency() * std::sin(frequency() * end_time()) * shape(coarse.rest[i]);
  }
  return {mesh_difference(finer, coarse, fine),
          (coarse.last() - coarse.rest - exact).norm() / exact.norm()};
}

// The solution has no singular edges, and both runs have the same small error of their steps, (ωh)²/24. A replica of
// both runs in numpy, with modes of linear elasticity, gave a first difference of 4.313 %, and errors of 6.060 % and
// 1.458 %.
TEST(MeshCheck, FindsAnErrorOfSecondOrderInASmoothMotion) {
  const TetMesh coarse = with_velocity(generate_box({1.0, kWidth, kWidth}, {4, 2, 2}));
  const Check first = check(coarse);
  const Check second = check(with_velocity(refined_mesh(coarse)));
  EXPECT_NEAR(first.difference, 0.04313, 1e-4);
  EXPECT_NEAR(first.error, 0.06060, 1e-4);
  EXPECT_NEAR(second.error, 0.01458, 1e-4);
  EXPECT_NEAR(std::log2(first.difference / second.difference), 2.0, 0.15);
  EXPECT_NEAR(std::log2(first.error / second.error), 2.0, 0.15);
  for (const Check& each : {first, second}) {
    MeshCheck result;
    result.difference = each.difference;
    EXPECT_NEAR(result.estimated_error() / each.error, 1.0, 0.2);
  }
}

}  // namespace
}  // namespace tetraction
