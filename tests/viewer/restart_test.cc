// A run that starts again: what it keeps of what was done by hand.
#include <algorithm>

#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

Scene beam_scene() {
  Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {4, 2, 2}}, elastic(1e5, 0.3));
  scene.time = {Integrator::kVerlet, 1e-3, false, 1.0};
  scene.initial.velocity = {0.3, -0.2, 0.5};
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

std::size_t held(const Simulation& simulation) {
  const auto snapshot = simulation.snapshot();
  return static_cast<std::size_t>(std::count(snapshot->fixed.begin(), snapshot->fixed.end(), 1));
}

FixSettings fix_of(std::vector<std::int64_t> ids) {
  return fix(SelectVertices{std::move(ids)});
}

TEST(Restart, KeepsSettingsAndGoesBackToTheStart) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  const auto start = simulation->snapshot();
  make_steps(*simulation, 5);
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 5e4;
  simulation->edit(SetMaterial{0, softer}, "Young's modulus 5e4 Pa");
  simulation->edit(SetDamping{{.viscosity = 50.0}}, "viscosity 50 Pa s");
  make_steps(*simulation, 5);
  simulation->edit(SetTime{{Integrator::kMidpoint, 2e-3, false, 1.0}}, "midpoint");
  simulation->edit(SetDamping{{.viscosity = 80.0}}, "viscosity 80 Pa s");
  make_steps(*simulation, 5);
  restart(*simulation);
  expect_no_notices(*simulation);
  const auto again = simulation->snapshot();
  EXPECT_EQ(again->step, 0);
  EXPECT_EQ(again->time, 0.0);
  EXPECT_FALSE(again->running);
  EXPECT_GT(again->body, start->body);
  EXPECT_EQ(again->position, start->position);
  EXPECT_EQ(again->momentum, start->momentum);
  EXPECT_EQ(simulation->history(0).size(), 1U);
  const Settings settings = simulation->settings();
  EXPECT_EQ(*settings.materials[0].youngs_modulus, 5e4);
  EXPECT_EQ(settings.damping.viscosity, 80.0);
  EXPECT_EQ(settings.time.integrator, Integrator::kMidpoint);
  EXPECT_EQ(settings.time.step, 2e-3);
  // As if it had been set at the start.
  Scene other = scene;
  other.material = softer;
  other.damping.viscosity = 80.0;
  other.time = {Integrator::kMidpoint, 2e-3, false, 1.0};
  const auto direct = simulation_of(other);
  make_steps(*simulation, 10);
  make_steps(*direct, 10);
  EXPECT_LT((simulation->snapshot()->position - direct->snapshot()->position).norm(), 1e-12);
}

TEST(Restart, EachKeptSettingCanBeUndone) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  simulation->edit(SetDamping{{.viscosity = 50.0}}, "viscosity");
  make_steps(*simulation, 3);
  simulation->edit(SetTime{{Integrator::kMidpoint, 2e-3, false, 1.0}}, "midpoint");
  restart(*simulation);
  EXPECT_EQ(simulation->settings().time.step, 2e-3);
  EXPECT_EQ(simulation->undo_text(), "Restart");
  undo(*simulation);
  EXPECT_EQ(simulation->undo_text(), "midpoint");
  undo(*simulation);
  EXPECT_EQ(simulation->settings().time.step, 1e-3);
  EXPECT_EQ(simulation->undo_text(), "viscosity");
  undo(*simulation);
  EXPECT_EQ(simulation->settings().damping.viscosity, 0.0);
  EXPECT_EQ(simulation->undo_text(), "");
  // What is undone is not kept.
  restart(*simulation);
  EXPECT_EQ(simulation->settings().time.step, 1e-3);
  EXPECT_TRUE(simulation->recorded_scene().event.empty());
}

TEST(Restart, KeepsWhatIsFixedAndReleased) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  const auto start = simulation->snapshot();
  const std::size_t clamped = held(*simulation);
  make_steps(*simulation, 20);
  const Index n = simulation->mesh().vertex_count();
  const std::int64_t tip = simulation->mesh().vertex_id(n - 1);
  const std::int64_t other = simulation->mesh().vertex_id(n - 2);
  const std::int64_t placed = simulation->mesh().vertex_id(n - 3);
  const std::int64_t clamp = simulation->mesh().vertex_id(0);
  simulation->edit(SetFix{std::nullopt, fix_of({tip, other})}, "Fix 2 vertices");
  simulation->edit(Unfix{SelectVertices{{other}}, {}}, "Unfix vertex");
  simulation->edit(Unfix{SelectVertices{{clamp}}, {}}, "Unfix vertex of the clamp");
  FixSettings at = fix_of({placed});
  const Vector3 place = vertex_block(start->position, n - 3) + Vector3(0.05, 0.0, 0.0);
  at.targets = {place};
  simulation->edit(SetFix{std::nullopt, at}, "Fix vertex at a place");
  make_steps(*simulation, 20);
  restart(*simulation);
  expect_no_notices(*simulation);
  const auto again = simulation->snapshot();
  EXPECT_EQ(held(*simulation), clamped + 2 - 1);
  EXPECT_EQ(again->fixed[static_cast<std::size_t>(n - 1)], 1);
  EXPECT_EQ(again->fixed[static_cast<std::size_t>(n - 2)], 0);
  EXPECT_EQ(again->fixed[static_cast<std::size_t>(n - 3)], 1);
  EXPECT_EQ(again->fixed[0], 0);
  // Where it is at the start; and at the place that was given.
  EXPECT_EQ(vertex_block(again->position, n - 1), vertex_block(start->position, n - 1));
  EXPECT_LT((vertex_block(again->position, n - 3) - place).norm(), 1e-12);
  make_steps(*simulation, 20);
  EXPECT_EQ(vertex_block(simulation->snapshot()->position, n - 1),
            vertex_block(start->position, n - 1));
}

TEST(Restart, ForcesStayMovesAndKicksAreOver) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  const auto start = simulation->snapshot();
  make_steps(*simulation, 5);
  const Index n = simulation->mesh().vertex_count();
  const std::int64_t tip = simulation->mesh().vertex_id(n - 1);
  ForceSettings pull = load(SelectVertices{{tip}}, {0.0, 7.0, 0.0});
  simulation->edit(SetForce{std::nullopt, pull}, "Force");
  simulation->edit(SetMomentum{{SelectVertices{{tip}}, {0.0, 0.0, 3.0}, {}}}, "Momentum");
  simulation->edit(ShiftState{{{tip}, {Vector3(0.01, 0.0, 0.0)}, {}, {}}}, "Move");
  make_steps(*simulation, 5);
  restart(*simulation);
  const auto again = simulation->snapshot();
  EXPECT_EQ(again->position, start->position);
  EXPECT_EQ(again->momentum, start->momentum);
  EXPECT_EQ(vertex_block(again->external_force, n - 1), Vector3(0.0, 7.0, 0.0));
  EXPECT_EQ(simulation->undo_text(), "Restart");
}

TEST(Restart, TheScenesEventsHappenAgainAtTheirTimes) {
  Scene scene = beam_scene();
  scene.event.push_back({5e-3, {SetDamping{{.viscosity = 50.0}}}, {}, {}});
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 10);
  EXPECT_EQ(simulation->settings().damping.viscosity, 50.0);
  simulation->edit(SetTime{{Integrator::kMidpoint, 1e-3, false, 1.0}}, "midpoint");
  restart(*simulation);
  EXPECT_EQ(simulation->settings().damping.viscosity, 0.0);
  EXPECT_EQ(simulation->settings().time.integrator, Integrator::kMidpoint);
  make_steps(*simulation, 10);
  EXPECT_EQ(simulation->settings().damping.viscosity, 50.0);
}

TEST(Restart, TheRecordedSceneReplaysBitwise) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  const std::int64_t tip = simulation->mesh().vertex_id(simulation->mesh().vertex_count() - 1);
  simulation->edit(SetFix{std::nullopt, fix_of({tip})}, "Fix");
  simulation->edit(SetDamping{{.viscosity = 50.0}}, "viscosity");
  make_steps(*simulation, 5);
  simulation->restart();
  make_steps(*simulation, 7);
  simulation->edit(SetDamping{{.viscosity = 20.0}}, "viscosity");
  make_steps(*simulation, 7);
  expect_bitwise_equal(simulation->history(0),
                       history_of_run(simulation->recorded_scene(), simulation->mesh()));
}

// Rejected attempts reach beyond the times of the edits, and steps of the scene's events are cut.
TEST(Restart, TheRecordedSceneOfAdaptiveStepsReplaysBitwise) {
  for (const Integrator rule : all_integrators()) {
    for (const StepAdaptation adapt : {StepAdaptation::kError, StepAdaptation::kEnergy}) {
      if (adapt == StepAdaptation::kEnergy && !(is_implicit(rule) && is_variational(rule)))
        continue;
      SCOPED_TRACE(to_string(rule) + " by " + to_string(adapt));
      Scene scene = beam_scene();
      scene.time.integrator = rule;
      scene.time.adapt = adapt;
      scene.time.tolerance = 1e-5;
      scene.event.clear();
      scene.event.push_back({1.7 * scene.time.step, {SetDamping{{.viscosity = 5.0}}}, {}, {}});
      const auto simulation = simulation_of(scene);
      make_steps(*simulation, 9);
      const auto snapshot = simulation->snapshot();
      EXPECT_GT(snapshot->adapted_step, 0.0);
      const std::int64_t tip = simulation->mesh().vertex_id(simulation->mesh().vertex_count() - 1);
      simulation->edit(SetFix{std::nullopt, fix_of({tip})}, "Fix");
      make_steps(*simulation, 7);
      simulation->edit(SetDamping{{.viscosity = 20.0}}, "viscosity");
      make_steps(*simulation, 7);
      const Scene recorded = simulation->recorded_scene();
      ASSERT_EQ(recorded.event.size(), 3U);
      EXPECT_EQ(recorded.event[0].at, 1.7 * scene.time.step) << "steps land on the scene's events";
      expect_bitwise_equal(simulation->history(0), history_of_run(recorded, simulation->mesh()));
    }
  }
}

TEST(Restart, AfterAFailureAndWithTheMouseHoldingAVertex) {
  Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  const std::size_t clamped = held(*simulation);
  simulation->grab({simulation->mesh().vertex_count() - 1});
  simulation->edit(SetTime{{Integrator::kVerlet, 1.0, false, 1.0}}, "far too large");
  make_steps(*simulation, 10);
  ASSERT_EQ(simulation->snapshot()->status, RunStatus::kUnstable);
  simulation->release();
  restart(*simulation);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
  EXPECT_EQ(held(*simulation), clamped);
  EXPECT_EQ(simulation->settings().time.step, 1.0);
}

// The state, its history, its marks and the edits that can be undone come back, and the run goes on as if
// there had been no restart.
TEST(Restart, CanBeUndoneAndMadeAgain) {
  const Scene scene = beam_scene();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  simulation->edit(SetDamping{{.viscosity = 50.0}}, "viscosity");
  make_steps(*simulation, 5);
  const auto before = simulation->snapshot();
  const std::size_t generation = simulation->history_generation();
  restart(*simulation);
  make_steps(*simulation, 3);
  simulation->edit(SetDamping{{.viscosity = 70.0}}, "more");
  settle(*simulation);
  EXPECT_EQ(simulation->undo_text(), "more");
  undo(*simulation);
  EXPECT_EQ(simulation->undo_text(), "Restart");
  undo(*simulation);
  const auto again = simulation->snapshot();
  EXPECT_EQ(again->step, 10);
  EXPECT_EQ(again->position, before->position);
  EXPECT_EQ(again->momentum, before->momentum);
  EXPECT_GT(again->body, before->body);
  EXPECT_EQ(simulation->history(0).size(), 11U);
  EXPECT_NE(simulation->history_generation(), generation);
  EXPECT_EQ(simulation->marks().size(), 1U);
  EXPECT_EQ(simulation->undo_text(), "viscosity");
  EXPECT_EQ(simulation->redo_text(), "Restart");
  redo(*simulation);
  EXPECT_EQ(simulation->snapshot()->step, 0);
  undo(*simulation);
  make_steps(*simulation, 5);
  expect_bitwise_equal(simulation->history(0),
                       history_of_run(simulation->recorded_scene(), simulation->mesh()));
}

}  // namespace
}  // namespace tetraction::viewer
