// A run that pauses by itself, and the ways on.
#include <chrono>
#include <cmath>
#include <thread>

#include "support/rules.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

Scene cantilever() {
  Scene scene = scene_of({GeneratorKind::kBox, {0.6, 0.1, 0.1}, {9, 3, 3}}, elastic(1e6, 0.4));
  scene.time = {Integrator::kMidpoint, 5e-3, false, 0.05};
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

void run_until_it_pauses(Simulation& simulation) {
  simulation.run();
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < patience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const auto snapshot = simulation.snapshot();
    if (snapshot->pause != Pause::kNone || snapshot->status != RunStatus::kRunning) break;
  }
  settle(simulation);
}

void run_to_step(const Simulation& simulation, Index step) {
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (simulation.snapshot()->step < step && std::chrono::steady_clock::now() < patience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST(Pauses, AtTheEndAndThenNoMore) {
  const auto simulation = simulation_of(cantilever());
  simulation->set_pauses(true, false);
  run_until_it_pauses(*simulation);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd);
  EXPECT_EQ(simulation->snapshot()->step, 10);
  EXPECT_FALSE(simulation->snapshot()->running);
  simulation->run();
  run_to_step(*simulation, 15);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kNone);
  simulation->pause();
  settle(*simulation);
  EXPECT_GE(simulation->snapshot()->step, 15);
  restart(*simulation);
  run_until_it_pauses(*simulation);
  EXPECT_EQ(simulation->snapshot()->step, 10);
  // The same for a run that goes on when it is restarted or set up again.
  for (const bool sets_up : {false, true}) {
    simulation->run();
    run_to_step(*simulation, 15);
    if (sets_up) {
      simulation->set_up(cantilever(), "the same");
    } else {
      simulation->restart();
    }
    settle(*simulation);
    run_until_it_pauses(*simulation);
    EXPECT_EQ(simulation->snapshot()->step, 10) << sets_up;
    EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd) << sets_up;
  }
}

// The energies of a body at rest are mere round-off, whose errors are as large as they are.
TEST(Pauses, NotAtRest) {
  for (const Integrator rule : testing_support::all_rules()) {
    Scene scene = cantilever();
    scene.time.integrator = rule;
    if (!is_implicit(rule)) scene.time.step = 2e-4;
    scene.time.end = 200 * scene.time.step;
    const auto simulation = simulation_of(scene);
    simulation->set_pauses(true, true);
    run_until_it_pauses(*simulation);
    EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd) << to_string(rule);
  }
}

// At the start of a fall the error of a rule of first order is large beside the little energy that has entered.
TEST(Pauses, NotAtTheStartOfAMotion) {
  for (const Integrator rule : testing_support::all_rules()) {
    Scene scene = cantilever();
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.time.integrator = rule;
    scene.time.step = is_implicit(rule) ? 1e-4 : 1e-5;
    scene.time.end = 150 * scene.time.step;
    const auto simulation = simulation_of(scene);
    simulation->set_pauses(true, true);
    run_until_it_pauses(*simulation);
    EXPECT_EQ(simulation->snapshot()->pause, Pause::kEnd)
        << to_string(rule) << " at step " << simulation->snapshot()->step;
  }
}

// Midpoint gains energy at large strains and steps: the finding of docs/theory.md.
TEST(Pauses, WhenTheEnergyErrorIsLarge) {
  Scene scene = cantilever();
  scene.initial.velocity = {0.0, 12.0, 0.0};
  scene.time.retry = 6;
  const auto simulation = simulation_of(scene);
  simulation->set_pauses(false, true);
  simulation->edit(SetDamping{{.drag = 0.0}}, "an edit");
  run_until_it_pauses(*simulation);
  const auto paused = simulation->snapshot();
  ASSERT_EQ(paused->pause, Pause::kEnergyError) << paused->message;
  EXPECT_GT(std::abs(paused->energy_error), 0.01 * paused->energy_entered);
  // The other rule keeps the energy from there on.
  TimeSettings time = simulation->settings().time;
  time.integrator = Integrator::kEnergyMomentum;
  simulation->edit(SetTime{time}, "energy-momentum");
  settle(*simulation);
  EXPECT_EQ(simulation->snapshot()->pause, Pause::kNone);
  const double error = simulation->history(0).back().energy_error;
  make_steps(*simulation, 5);
  EXPECT_NEAR(simulation->history(0).back().energy_error, error, 1e-4 * paused->energy_entered);
}

TEST(Pauses, BackBeforeTheLastEditBringsTheStateBack) {
  const auto simulation = simulation_of(cantilever());
  make_steps(*simulation, 5);
  const auto before = simulation->snapshot();
  EXPECT_FALSE(before->knows_last_edit);
  simulation->edit(SetMomentum{{SelectPlane{0, 0.6, {}}, {0.0, 0.2, 0.0}, {}}}, "kick");
  make_steps(*simulation, 20);
  EXPECT_TRUE(simulation->snapshot()->knows_last_edit);
  simulation->go_before_last_edit();
  settle(*simulation);
  const auto after = simulation->snapshot();
  EXPECT_LT((after->position - before->position).norm(), 1e-12);
  EXPECT_LT((after->momentum - before->momentum).norm(), 1e-12);
  EXPECT_EQ(after->step, 25) << "the time goes on";
  EXPECT_FALSE(after->knows_last_edit);
  make_steps(*simulation, 5);
  expect_bitwise_equal(simulation->history(0),
                       history_of_run(simulation->recorded_scene(), simulation->mesh()));
}

// A warning goes with the setting that it is about, a refusal with the next command that succeeds.
TEST(Pauses, NoticesEndWithTheirCauses) {
  Scene scene = cantilever();
  const auto simulation = simulation_of(scene);
  expect_no_notices(*simulation);
  MaterialSettings rubber = scene.material;
  rubber.poissons_ratio = 0.4999;
  simulation->edit(SetMaterial{0, rubber}, "nearly incompressible");
  settle(*simulation);
  const std::vector<Notice> warnings = simulation->take_notices();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_FALSE(warnings[0].cause.empty());
  EXPECT_TRUE(simulation->take_ended_causes().empty());
  undo(*simulation);
  EXPECT_EQ(simulation->take_ended_causes(), std::vector{warnings[0].cause});

  simulation->edit(RemoveConstraint{7}, "none");
  settle(*simulation);
  const std::vector<Notice> refusals = simulation->take_notices();
  ASSERT_EQ(refusals.size(), 1U);
  make_steps(*simulation, 1);
  EXPECT_EQ(simulation->take_ended_causes(), std::vector{refusals[0].cause});
}

}  // namespace
}  // namespace tetraction::viewer
