// Observed orders in the step, from the study's own table.
#include "support/bodies.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(Orders, ExplicitAndBackwardEulerOneVerletAndMidpointTwo) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.08);
  scene.solver.tolerance = 1e-11;
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  StudySettings settings;
  settings.steps = {0.08 / 1024, 0.08 / 512, 0.08 / 256};
  settings.reference_step = 0.08 / 8192;
  const StudyResult result = run_study(scene, mesh, settings);
  ASSERT_EQ(result.rows.size(), 16U);  // with the reference
  ASSERT_EQ(result.reference_status, RunStatus::kFinished);
  EXPECT_LT(settings.steps.back(), result.stable_step);
  int compared = 0;
  for (const StudyRow& row : result.rows) {
    ASSERT_EQ(row.status, RunStatus::kFinished) << row.message;
    if (std::isnan(row.observed_order)) continue;
    ++compared;
    const bool first =
        row.integrator == Integrator::kExplicit || row.integrator == Integrator::kBackwardEuler;
    EXPECT_NEAR(row.observed_order, first ? 1.0 : 2.0, 0.1)
        << to_string(row.integrator) << " " << row.step;
  }
  EXPECT_EQ(compared, 10);
}

TEST(Orders, TheReferencesOwnFamilyIsCorrectedForTheReferencesError) {
  // e(h) = h² − h_r² exactly.
  constexpr double kReference = 0.1;
  const auto error = [&](double h) { return h * h - kReference * kReference; };
  EXPECT_NEAR(observed_order(0.2, error(0.2), 0.4, error(0.4), kReference), 2.0, 1e-9);
  EXPECT_NEAR(observed_order(0.2, 0.2, 0.4, 0.4), 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(observed_order(0.2, 0.4, 0.4, 0.2)));
}

TEST(Study, UnstableRunsAreResults) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 5.0);
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  StudySettings settings;
  settings.integrators = {Integrator::kExplicit, Integrator::kMidpoint};
  settings.steps = {5.0 / 400, 5.0 / 40};
  const StudyResult result = run_study(scene, mesh, settings);
  ASSERT_EQ(result.rows.size(), 4U);
  EXPECT_EQ(result.rows[0].status, RunStatus::kFinished);
  EXPECT_EQ(result.rows[1].status, RunStatus::kUnstable);
  EXPECT_TRUE(std::isnan(result.rows[1].position_error));
  EXPECT_EQ(result.rows[2].status, RunStatus::kFinished);
  EXPECT_EQ(result.rows[2].position_error, 0.0) << "the finest midpoint run is the reference";
  EXPECT_GT(result.rows[3].position_error, 0.0);
}

// Stops the run that it watches after a few steps.
class Stopper : public Observer {
 public:
  bool on_step(const Session& session) override { return session.step_number() < 3; }
};

TEST(Study, InterruptedKeepsWhatIsKnown) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.08);
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  StudySettings settings;
  settings.integrators = {Integrator::kMidpoint, Integrator::kVerlet};
  settings.steps = {0.08 / 512, 0.08 / 256, 0.08 / 128};
  settings.reference_step = 0.08 / 4096;
  const StudyPlan plan = plan_study(scene, mesh, settings);
  const std::string last = plan.runs.back().directory;
  const auto observers = [&](const std::string& directory) {
    std::vector<std::unique_ptr<Observer>> result;
    if (directory == last) result.push_back(std::make_unique<Stopper>());
    return result;
  };
  const StudyResult result = run_study(plan, mesh, observers);
  EXPECT_TRUE(result.is_interrupted);
  EXPECT_EQ(result.reference_status, RunStatus::kFinished);
  EXPECT_GT(result.reference_error, 0.0);
  std::vector<StudyRow> asked = result.rows;
  EXPECT_EQ(std::erase_if(asked, [](const StudyRow& row) { return row.role != StudyRole::kRun; }),
            1U);  // the reference
  ASSERT_EQ(asked.size(), 6U);
  EXPECT_EQ(asked.back().status, RunStatus::kCancelled);
  EXPECT_NEAR(asked[2].observed_order, 2.0, 0.2);
  EXPECT_NEAR(asked[4].observed_order, 2.0, 0.2);
  EXPECT_TRUE(std::isnan(asked[5].observed_order));
}

}  // namespace
}  // namespace tetraction
