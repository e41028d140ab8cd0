// What a study calls an error: it does not depend on where the body is, and it sees a motion that is
// lost.
#include <cmath>
#include <map>
#include <numbers>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A cantilever that is let go at a speed; the body may lie anywhere.
Scene swinging_beam() {
  Scene scene;
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.3;
  scene.time = {Integrator::kMidpoint, 1e-2, false, 2.0};
  scene.initial.velocity = {0.0, 0.2, 0.0};
  FixSettings clamp;
  clamp.select = SelectVertices{{0, 5, 10, 15}};  // x = 0
  scene.fix.push_back(clamp);
  return scene;
}

TetMesh beam_at(const Vector3& corner) {
  TetMesh mesh = generate_box({4, 1, 1}, {4, 1, 1});
  for (Vector3& x : mesh.vertices.own()) x += corner;
  return mesh;
}

TEST(CornersOfStudies, ErrorsDoNotDependOnTheOrigin) {
  StudySettings settings;
  settings.integrators = {Integrator::kMidpoint, Integrator::kBackwardEuler};
  settings.steps = {0.01, 0.02, 0.05};
  const StudyResult here = run_study(swinging_beam(), beam_at({0, 0, 0}), settings);
  const StudyResult there = run_study(swinging_beam(), beam_at({4096, -8192, 1024}), settings);
  ASSERT_EQ(here.rows.size(), 6U);
  for (std::size_t i = 0; i < here.rows.size(); ++i) {
    const StudyRow& a = here.rows[i];
    const StudyRow& b = there.rows[i];
    ASSERT_EQ(a.status, RunStatus::kFinished) << a.message;
    EXPECT_NEAR(a.position_error, b.position_error, 1e-6 * a.position_error) << i;
    EXPECT_NEAR(a.position_error_rms, b.position_error_rms, 1e-6 * a.position_error_rms) << i;
  }
}

TEST(CornersOfStudies, ALostMotionIsAnErrorOfOrderOne) {
  StudySettings settings;
  settings.integrators = {Integrator::kVerlet, Integrator::kMidpoint, Integrator::kBackwardEuler};
  settings.steps = {0.002, 0.25};
  const StudyResult result = run_study(swinging_beam(), beam_at({100, 0, 0}), settings);
  for (const StudyRow& row : result.rows) {
    EXPECT_EQ(row.role, StudyRole::kRun);
    if (row.is_reference) {
      EXPECT_EQ(row.integrator, Integrator::kMidpoint);
      EXPECT_EQ(row.position_error, 0.0);
      EXPECT_EQ(row.position_error_rms, 0.0);
      EXPECT_EQ(row.status, RunStatus::kFinished);
      continue;
    }
    if (row.integrator == Integrator::kBackwardEuler && row.step == 0.25) {
      EXPECT_GT(row.position_error_rms, 0.5) << "the beam has come to rest";
      EXPECT_LT(row.position_error_rms, 1.5);
    }
    if (row.integrator == Integrator::kVerlet && row.step == 0.002) {
      EXPECT_LT(row.position_error_rms, 0.01);
    }
  }
}

// With steps whose multiples hardly coincide the reference is interpolated, which must not show.
TEST(CornersOfStudies, TheErrorOverTimeHasTheOrderOfTheRule) {
  Scene scene = swinging_beam();
  // Without a force at the start `explicit` is of second order, too.
  scene.environment.kind = EnvironmentKind::kGravity;
  StudySettings settings;
  settings.integrators = {Integrator::kVerlet, Integrator::kExplicit};
  settings.steps = {2.0 / 1501, 2.0 / 751};
  settings.reference_step = 2.0 / 4003;
  settings.reference_integrator = Integrator::kVerlet;
  const StudyResult result = run_study(scene, beam_at({0, 0, 0}), settings);
  ASSERT_EQ(result.rows.size(), 5U);
  EXPECT_TRUE(result.rows[0].is_reference);
  EXPECT_EQ(result.rows[0].role, StudyRole::kReference);
  for (const StudyRow& row : result.rows) ASSERT_EQ(row.status, RunStatus::kFinished);
  const auto order = [&](std::size_t fine, double reference) {
    return observed_order(result.rows[fine].step, result.rows[fine].position_error_rms,
                          result.rows[fine + 1].step, result.rows[fine + 1].position_error_rms,
                          reference);
  };
  EXPECT_NEAR(order(1, result.reference_step), 2.0, 0.1);
  EXPECT_NEAR(order(3, 0.0), 1.0, 0.1);
}

TEST(CornersOfStudies, VariantsDifferAndMustEndTogether) {
  StudySettings settings;
  settings.integrators = {Integrator::kMidpoint};
  settings.steps = {0.05};
  Scene soft = swinging_beam();
  soft.material.youngs_modulus = 5e5;
  settings.variants = {{"hard", swinging_beam()}, {"soft", soft}};
  const TetMesh mesh = beam_at({0, 0, 0});
  const StudyResult result = run_study(settings.variants[0].scene, mesh, settings);
  // Each of them with a second run for the error of its reference.
  ASSERT_EQ(result.rows.size(), 4U);
  EXPECT_TRUE(result.rows[0].is_reference);
  EXPECT_EQ(result.rows[1].role, StudyRole::kReference);
  EXPECT_GT(result.rows[1].position_error, 0.0);
  EXPECT_GT(result.reference_error, 0.0);
  EXPECT_TRUE(result.rows[2].is_reference);  // its motion is another one
  ASSERT_EQ(result.references.size(), 2U);
  EXPECT_TRUE(std::isnan(result.references[0].difference.position_rms));
  EXPECT_GT(result.references[1].difference.position, 0.1);
  EXPECT_GT(result.references[1].difference.position_rms, 0.1);
  settings.variants[1].scene.time.end = 1.0;
  EXPECT_THROW(run_study(settings.variants[0].scene, mesh, settings), InputError);
}

TEST(CornersOfStudies, RunsAreComparedAfterwards) {
  StudySettings settings;
  settings.integrators = {Integrator::kVerlet, Integrator::kMidpoint};
  settings.steps = {0.01, 0.02, 0.05};
  const TetMesh mesh = beam_at({0, 0, 0});
  const StudyPlan plan = plan_study(swinging_beam(), mesh, settings);
  std::map<std::string, StudyRow> rows;
  std::map<std::string, std::shared_ptr<const MotionTrack>> tracks;
  StudyMemory memory;
  memory.made = [&](const PlannedRun& run, const StudyRow& row, const MotionTrack& track) {
    EXPECT_TRUE(std::isnan(row.position_error));
    rows[run.directory] = row;
    tracks[run.directory] = std::make_shared<const MotionTrack>(track);
  };
  memory.track = [&](const PlannedRun& run) { return tracks[run.directory]; };
  const StudyResult whole = run_study(plan, mesh, {}, {}, memory);
  // With some of the runs, and with none to be made.
  for (const std::string& missing : {std::string("midpoint-0.01"), std::string("none")}) {
    rows.erase(missing);
    std::size_t made = 0;
    const std::size_t expected = plan.runs.size() - rows.size();
    memory.kept = [&](const PlannedRun& run) {
      const auto found = rows.find(run.directory);
      return found == rows.end() ? std::nullopt : std::optional(found->second);
    };
    const StudyResult again = run_study(
        plan, mesh, {}, [&](std::size_t, std::size_t, const PlannedRun&) { ++made; }, memory, 2);
    EXPECT_EQ(made, expected);
    ASSERT_EQ(again.rows.size(), whole.rows.size());
    EXPECT_EQ(again.reference_error, whole.reference_error);
    for (std::size_t i = 0; i < whole.rows.size(); ++i) {
      const StudyRow& a = whole.rows[i];
      const StudyRow& b = again.rows[i];
      for (double StudyRow::*const number :
           {&StudyRow::position_error, &StudyRow::position_error_rms, &StudyRow::observed_order}) {
        const bool are_unknown = std::isnan(a.*number) && std::isnan(b.*number);
        EXPECT_TRUE(are_unknown || a.*number == b.*number) << a.directory;
      }
    }
  }
}

TEST(CornersOfStudies, RepeatsThatEndDifferentlyDoNotCount) {
  StudySettings settings;
  settings.integrators = {Integrator::kMidpoint};
  settings.steps = {0.02};
  settings.repeats = 1;
  Scene scene = swinging_beam();
  scene.time.end = 0.2;
  const TetMesh mesh = beam_at({0, 0, 0});
  const StudyPlan plan = plan_study(scene, mesh, settings);
  for (const double moved : {0.0, 1e-9}) {
    std::map<std::string, MotionTrack> tracks;
    StudyMemory memory;
    memory.made = [&](const PlannedRun& run, const StudyRow&, const MotionTrack& track) {
      tracks[run.directory] = track;
    };
    memory.track = [&](const PlannedRun& run) {
      auto track = std::make_shared<MotionTrack>(tracks.at(run.directory));
      track->positions.back()[20] += moved;
      return track;
    };
    const StudyResult result = run_study(plan, mesh, {}, {}, memory);
    const bool is_same = moved == 0.0;
    int differ = 0;
    for (const std::string& remark : result.remarks) {
      differ += remark.find("ended differently") != std::string::npos ? 1 : 0;
    }
    EXPECT_EQ(differ, is_same ? 0 : 1);
    EXPECT_EQ(result.rows.front().repeats, is_same ? 1 : 0);
    EXPECT_EQ(std::isnan(result.rows.front().time_scatter), !is_same);
  }
}

// Two rules that agree with each other far better than with a coarse reference of first order.
TEST(CornersOfStudies, AReferenceThatIsWorseThanTheRunsIsNamed) {
  StudySettings settings;
  settings.integrators = {Integrator::kMidpoint};
  settings.steps = {1.0 / 2048, 1.0 / 1024};
  settings.reference_integrator = Integrator::kBackwardEuler;
  settings.reference_step = 1.0 / 2048;
  Scene scene = swinging_beam();
  scene.time.end = 0.25;
  const StudyResult result = run_study(scene, beam_at({0, 0, 0}), settings);
  ASSERT_EQ(result.remarks.size(), 1U);
  EXPECT_NE(result.remarks[0].find("are those of the reference"), std::string::npos);
  EXPECT_GE(result.reference_error, result.rows[0].position_error);
  EXPECT_TRUE(std::isnan(result.rows[1].observed_order));
  // A better reference shows the order.
  settings.reference_integrator = Integrator::kVerlet;
  settings.reference_step = 1.0 / 32768;
  const StudyResult better = run_study(scene, beam_at({0, 0, 0}), settings);
  EXPECT_TRUE(better.remarks.empty());
  EXPECT_NEAR(better.rows[1].observed_order, 2.0, 0.1);
}

TEST(CornersOfStudies, ABodyAtRestHasNoError) {
  Scene scene = swinging_beam();
  scene.initial = {};
  StudySettings settings;
  settings.steps = {0.005};
  const StudyResult result = run_study(scene, beam_at({0, 0, 0}), settings);
  for (const StudyRow& row : result.rows) {
    EXPECT_LT(row.position_error, 1e-3) << to_string(row.integrator);
    EXPECT_LT(row.position_error_rms, 1e-3) << to_string(row.integrator);
  }
}

}  // namespace
}  // namespace tetraction
