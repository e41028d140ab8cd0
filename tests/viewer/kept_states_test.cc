// States that a run keeps: it shows them, and goes on from them.
#include "viewer/kept_states.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>

#include "tetraction/io/run_recorder.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

std::shared_ptr<const KeptState> kept_at(Index step, Index dofs = 300) {
  KeptState kept;
  kept.state.step = step;
  kept.state.time = 0.01 * static_cast<double>(step);
  kept.state.position = kept.state.momentum = kept.state.velocity = Vector::Zero(dofs);
  static const auto settings =
      std::make_shared<const KeptSettings>(KeptSettings{{}, {}, 0, 0, 0, Numbering(Scene()), 0.0});
  kept.settings = settings;
  return std::make_shared<const KeptState>(std::move(kept));
}

TEST(KeptStates, CoverTheWholeRunInBoundedMemory) {
  constexpr std::size_t kBudget = 1'000'000;
  KeptStates kept(kBudget);
  for (Index step = 0; step <= 5000; ++step) {
    if (kept.wants(step)) kept.add(kept_at(step));
    ASSERT_LE(kept.bytes(), kBudget);
  }
  EXPECT_GT(kept.bytes(), kBudget / 3);
  const std::vector<double> times = kept.times();
  EXPECT_EQ(times.front(), 0.0);
  EXPECT_GT(times.back(), 49.0);
  ASSERT_GT(times.size(), 40U);
  for (std::size_t i = 2; i < times.size(); ++i) {
    EXPECT_NEAR(times[i] - times[i - 1], times[1] - times[0], 1e-9) << i;
  }
  EXPECT_EQ(kept.nearest(0.4 * times[1])->state.step, 0);
  EXPECT_EQ(kept.nearest(1e9)->state.time, times.back());
  kept.go_back_to(2000);
  EXPECT_LE(kept.times().back(), 20.0);
  EXPECT_EQ(KeptStates().nearest(1.0), nullptr);
}

Scene swinging_beam() {
  Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {4, 2, 2}}, elastic(1e5, 0.3));
  scene.time = {Integrator::kMidpoint, 2e-3, false, 1.0};
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  EventSettings event;
  event.at = 0.03;
  event.edits = {SetDamping{{.viscosity = 20.0}}};
  scene.event.push_back(event);
  return scene;
}

void show_at(Simulation& simulation, double time) {
  simulation.show_at(time);
  settle(simulation);
}
void continue_here(Simulation& simulation) {
  simulation.continue_here();
  settle(simulation);
}

TEST(KeptStates, AreShownWithoutAChangeOfTheRun) {
  const auto simulation = simulation_of(swinging_beam());
  simulation->set_color_field(find_quantity("von_mises"));
  make_steps(*simulation, 10);
  const auto tenth = simulation->snapshot();
  make_steps(*simulation, 10);
  const auto now = simulation->snapshot();
  EXPECT_EQ(simulation->kept_times().size(), 21U);
  show_at(*simulation, tenth->time + 2e-4);
  const auto shown = simulation->snapshot();
  EXPECT_TRUE(shown->earlier);
  EXPECT_EQ(shown->step, 10);
  EXPECT_EQ(shown->newest, now->time);
  EXPECT_EQ(shown->position, tenth->position);
  EXPECT_EQ(shown->momentum, tenth->momentum);
  EXPECT_EQ(shown->field_values, tenth->field_values);
  EXPECT_NE(shown->field_values, now->field_values);
  EXPECT_EQ(shown->fixed, tenth->fixed);
  EXPECT_EQ(simulation->history(0).size(), 21U);
  show_at(*simulation, std::numeric_limits<double>::infinity());
  EXPECT_FALSE(simulation->snapshot()->earlier);
  EXPECT_EQ(simulation->snapshot()->position, now->position);
  // An undo concerns the run, not what is shown.
  simulation->edit(SetDamping{{.viscosity = 5.0}}, "viscosity");
  show_at(*simulation, 0.0);
  undo(*simulation);
  EXPECT_FALSE(simulation->snapshot()->earlier);
  EXPECT_EQ(simulation->snapshot()->step, 20);
}

TEST(KeptStates, ARunContinuesFromOneWithTheSettingsOfNow) {
  const Scene scene = swinging_beam();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  simulation->edit(SetDamping{{.drag = 0.5}}, "drag");
  make_steps(*simulation, 5);
  const auto tenth = simulation->snapshot();
  const std::vector<HistoryRow> rows = simulation->history(0);
  make_steps(*simulation, 10);  // with the event at step 15
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 5e4;
  simulation->edit(SetMaterial{0, softer}, "softer");
  make_steps(*simulation, 5);
  const auto last = simulation->snapshot();
  const std::vector<HistoryRow> all = simulation->history(0);

  show_at(*simulation, tenth->time);
  continue_here(*simulation);
  expect_no_notices(*simulation);
  auto now = simulation->snapshot();
  EXPECT_FALSE(now->earlier);
  EXPECT_EQ(now->step, 10);
  EXPECT_EQ(now->position, tenth->position);
  EXPECT_EQ(now->momentum, tenth->momentum);
  expect_bitwise_equal(simulation->history(0), rows);
  EXPECT_EQ(simulation->kept_times().back(), tenth->time);
  EXPECT_EQ(*simulation->settings().materials[0].youngs_modulus, 5e4) << "as it is now";
  EXPECT_EQ(simulation->settings().damping.drag, 0.5);
  EXPECT_EQ(simulation->settings().damping.viscosity, 0.0) << "the event is still to come";
  for (const EditMark& mark : simulation->marks()) EXPECT_LE(mark.time, tenth->time) << mark.what;

  make_steps(*simulation, 12);
  EXPECT_EQ(simulation->settings().damping.viscosity, 20.0) << "the event came again";
  // The history has no jump, and the scene with all edits repeats it.
  const Scene recorded = simulation->recorded_scene();
  expect_bitwise_equal(history_of_run(recorded, mesh_of(recorded)), simulation->history(0));

  EXPECT_NE(simulation->undo_text().find("Continue"), std::string::npos);
  undo(*simulation);
  now = simulation->snapshot();
  EXPECT_EQ(now->step, last->step);
  EXPECT_EQ(now->position, last->position);
  expect_bitwise_equal(simulation->history(0), all);
  EXPECT_EQ(simulation->kept_times().size(), all.size());
  EXPECT_EQ(simulation->undo_text(), "softer");
  redo(*simulation);
  EXPECT_EQ(simulation->snapshot()->step, 22);
  // A restart keeps the settings from before and after.
  restart(*simulation);
  EXPECT_EQ(simulation->snapshot()->step, 0);
  EXPECT_EQ(simulation->settings().damping.drag, 0.5);
  EXPECT_EQ(*simulation->settings().materials[0].youngs_modulus, 5e4);
}

// The user has let the run go on beyond its end, so that it does not stop there again.
TEST(KeptStates, ContinuingBeyondTheEndGoesOn) {
  Scene scene = swinging_beam();
  scene.time.end = 0.02;
  const auto simulation = simulation_of(scene);
  simulation->set_pauses(true, false);
  make_steps(*simulation, 10);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd);
  make_steps(*simulation, 20);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kNone);
  show_at(*simulation, 0.04);
  continue_here(*simulation);
  make_steps(*simulation, 1);
  EXPECT_EQ(simulation->snapshot()->step, 21);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kNone);
  // Before the end it does.
  show_at(*simulation, 0.01);
  continue_here(*simulation);
  make_steps(*simulation, 5);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd);
}

TEST(KeptStates, ContinuingFollowsFixesLoadsAndUndoneEdits) {
  const Scene scene = swinging_beam();
  const auto simulation = simulation_of(scene);
  const Index n = simulation->mesh().vertex_count();
  const std::int64_t tip = simulation->mesh().vertex_id(n - 1);
  simulation->edit(SetForce{std::nullopt, load(SelectVertices{{tip}}, {0.0, 0.0, 30.0})}, "force");
  make_steps(*simulation, 10);
  const auto tenth = simulation->snapshot();
  simulation->edit(SetFix{std::nullopt, fix(SelectVertices{{tip}})}, "fix");
  simulation->edit(SetForce{0, load(SelectVertices{{tip}}, {0.0, 0.0, 60.0})}, "more force");
  make_steps(*simulation, 5);
  simulation->edit(SetDamping{{.viscosity = 9.0}}, "viscosity");
  make_steps(*simulation, 5);
  undo(*simulation);
  show_at(*simulation, tenth->time);
  simulation->step();  // continues from what is shown
  settle(*simulation);
  const auto now = simulation->snapshot();
  EXPECT_EQ(now->step, 11);
  EXPECT_EQ(now->fixed[static_cast<std::size_t>(n - 1)], 1);
  EXPECT_LT((vertex_block(now->position, n - 1) - vertex_block(tenth->position, n - 1)).norm(),
            1e-12)
      << "fixed where it was then";
  const Settings settings = simulation->settings();
  ASSERT_EQ(settings.loads.force.size(), 1U);
  EXPECT_EQ(settings.loads.force[0].vector.z(), 60.0);
  EXPECT_EQ(settings.damping.viscosity, 0.0);
  make_steps(*simulation, 10);
  const Scene recorded = simulation->recorded_scene();
  expect_bitwise_equal(history_of_run(recorded, mesh_of(recorded)), simulation->history(0));
}

// Nothing pulls any more when the run goes on from a moment of a drag.
TEST(KeptStates, ContinuingWithinADragLetsGo) {
  const auto simulation = simulation_of(swinging_beam());
  const Index tip = simulation->mesh().vertex_count() - 1;
  simulation->pull({tip});
  simulation->drag_to({2.5, 1.0, 1.5});
  make_steps(*simulation, 10);
  simulation->release();
  make_steps(*simulation, 3);
  show_at(*simulation, 0.01);
  continue_here(*simulation);
  make_steps(*simulation, 1);
  EXPECT_TRUE(simulation->snapshot()->pulled.empty());
  EXPECT_TRUE(simulation->settings().pull.vertices.empty());
}

class EndCounter : public Observer {
 public:
  explicit EndCounter(std::vector<Index>& steps) : steps_(steps) {}
  bool on_step(const Session& session) override {
    steps_.push_back(session.step_number());
    return true;
  }
  void on_finish(const Session& session) override { steps_.push_back(-session.step_number()); }

 private:
  std::vector<Index>& steps_;
};

TEST(KeptStates, ARecordingEndsBeforeTheRunContinuesFromAnEarlierState) {
  const auto simulation = simulation_of(swinging_beam());
  std::vector<Index> steps;
  simulation->observe(std::make_unique<EndCounter>(steps));
  make_steps(*simulation, 4);
  show_at(*simulation, 0.002);
  EXPECT_TRUE(simulation->observed()) << "looking back ends nothing";
  simulation->step();
  settle(*simulation);
  EXPECT_FALSE(simulation->observed());
  EXPECT_EQ(steps, (std::vector<Index>{1, 2, 3, 4, -4}));
  const std::vector<Notice> notices = simulation->take_notices();
  EXPECT_TRUE(std::any_of(notices.begin(), notices.end(),
                          [](const Notice& notice) { return notice.cause == "recording"; }));
}

TEST(KeptStates, AFailedRunContinuesFromAnEarlierState) {
  Scene scene = swinging_beam();
  scene.time = {Integrator::kVerlet, 1e-3, false, 1.0};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  simulation->edit(SetTime{{Integrator::kVerlet, 0.1, false, 100.0}}, "too large a step");
  simulation->run();
  settle(*simulation);
  ASSERT_EQ(simulation->snapshot()->status, RunStatus::kUnstable);
  show_at(*simulation, 2e-3);
  EXPECT_EQ(simulation->snapshot()->step, 2);
  simulation->edit(SetTime{{Integrator::kVerlet, 1e-3, false, 100.0}}, "the step as it was");
  make_steps(*simulation, 3);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
  EXPECT_EQ(simulation->snapshot()->step, 5);
  EXPECT_EQ(simulation->settings().time.step, 1e-3);
}

// A thousand states of 20,000 tetrahedra: their memory, and how fast the solver's thread shows them.
TEST(KeptStates, AThousandStatesOfTwentyThousandTetrahedra) {
  Scene scene = scene_of({GeneratorKind::kBox, {1, 1, 1}, {15, 15, 15}}, elastic(1e5, 0.3));
  scene.time = {Integrator::kVerlet, 1e-4, false, 1.0};
  const auto simulation = simulation_of(scene);
  simulation->set_color_field(find_quantity("von_mises"));
  ASSERT_GT(simulation->mesh().tetrahedron_count(), 20'000);
  const KeptStates one = [&] {
    KeptStates kept;
    kept.add(kept_at(0, 3 * simulation->mesh().vertex_count()));
    return kept;
  }();
  EXPECT_LE(1000 * one.bytes(), KeptStates::kBudget);
  make_steps(*simulation, 60);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  constexpr int kShown = 60;
  for (int i = 0; i < kShown; ++i) {
    show_at(*simulation, 1e-4 * ((37 * i) % 59));
    ASSERT_TRUE(simulation->snapshot()->earlier);
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  RecordProperty("shown_per_second", static_cast<int>(kShown / seconds));
  std::printf("%.0f states a second, %.1f kB each\n", kShown / seconds,
              1e-3 * static_cast<double>(one.bytes()));
  EXPECT_GT(kShown / seconds, 30.0);
}

}  // namespace
}  // namespace tetraction::viewer
