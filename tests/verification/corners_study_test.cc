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

// A slender bar of the length L and the wave speed c along x, held at x = 0, whose weight g (1 − cos Ωt) pulls along it:
// u = Σ f_n [(1 − cos ω_n t)/ω_n² − (cos Ωt − cos ω_n t)/(ω_n² − Ω²)] sin(k_n x), f_n = 2 g/(L k_n),
// k_n = (n − 1/2) π/L, ω_n = c k_n. Without lateral contraction this is exact for small strains.
struct PulledBar {
  double length = 4.0;
  double gravity = 1e-2;
  double frequency = 2.5;
  double end = 0.2;
  Scene scene;

  PulledBar() {
    scene.material.model = "stvk";
    scene.material.youngs_modulus = 1e6;
    scene.material.poissons_ratio = 0.0;
    scene.time = {Integrator::kVerlet, 2.5e-4, false, end};
    scene.environment = {EnvironmentKind::kGravity, gravity, {1.0, 0.0, 0.0}};
    scene.environment.amplitude = "smooth";
    AmplitudeSettings smooth;
    smooth.name = "smooth";
    smooth.kind = AmplitudeKind::kSine;
    smooth.frequency = frequency;
    smooth.phase = -0.5 * std::numbers::pi;
    smooth.offset = 1.0;
    scene.amplitude = {smooth};
    FixSettings clamp;
    clamp.select = SelectPlane{0, 0.0, {}};
    scene.fix.push_back(clamp);
  }

  double displacement(double x) const {
    const double speed = std::sqrt(*scene.material.youngs_modulus / scene.material.density);
    const double forced = 2.0 * std::numbers::pi * frequency;
    double u = 0.0;
    for (int n = 1; n <= 200; ++n) {
      const double k = (n - 0.5) * std::numbers::pi / length;
      const double own = speed * k;
      const double free = std::cos(own * end);
      u += 2.0 * gravity / (length * k) * std::sin(k * x) *
           ((1.0 - free) / (own * own) -
            (std::cos(forced * end) - free) / (own * own - forced * forced));
    }
    return u;
  }

  // |q − q_exact|₂/|q_exact − X|₂ at the end.
  double error(const MotionTrack& track) const {
    Vector exact = Vector::Zero(track.rest.size());
    for (Index i = 0; i < exact.size(); i += 3) exact[i] = displacement(track.rest[i]);
    return (track.last() - track.rest - exact).norm() / exact.norm();
  }
};

TEST(CornersOfStudies, TheCheckOfTheMeshTellsThreeQuartersOfItsError) {
  const PulledBar bar;
  TetMesh mesh = generate_box({bar.length, 1, 1}, {4, 1, 1});
  StudySettings settings;
  settings.integrators = {Integrator::kVerlet};
  settings.steps = {bar.scene.time.step};
  double difference_before = 0.0;
  double error_before = 0.0;
  for (int level = 0; level < 3; ++level) {
    const StudyPlan plan = plan_study(bar.scene, mesh, settings);
    const StudyPlan finer = mesh_check_plan(plan, mesh);
    const PlannedRun& run = finer.runs.front();
    ASSERT_EQ(run.step, bar.scene.time.step);
    ASSERT_EQ(coarse_run_of(run), plan.runs.front().directory);
    const TetMesh& fine_mesh = *finer.variants.front().mesh;
    const TrackedRun coarse = make_tracked_run(plan, plan.runs.front(), mesh, {}, {}, {});
    const TrackedRun fine = make_tracked_run(finer, run, fine_mesh, {}, {}, {});
    ASSERT_TRUE(coarse.track && fine.track);
    const double difference = mesh_difference(plan, *coarse.track, *fine.track);
    const double error = bar.error(*coarse.track);
    RecordProperty("difference_" + std::to_string(level), std::to_string(difference));
    RecordProperty("error_" + std::to_string(level), std::to_string(error));
    // Orders from 1.8 to 2.2 have 0.71 to 0.78; the two meshes have their norms over different vertices.
    EXPECT_NEAR(difference / error, 0.75, 0.06) << level;
    if (level > 0) {
      // Linear tetrahedra are of second order; half the edges have a quarter of the error.
      EXPECT_NEAR(std::log2(difference_before / difference), 2.0, 0.2) << level;
      EXPECT_NEAR(std::log2(error_before / error), 2.0, 0.2) << level;
    }
    difference_before = difference;
    error_before = error;
    mesh = TetMesh(fine_mesh);
  }
}

}  // namespace
}  // namespace tetraction
