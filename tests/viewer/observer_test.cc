// Observers of a simulation: recordings while it runs.
#include <algorithm>
#include <filesystem>

#include "io/text/output_file.h"
#include "support/gated_material.h"
#include "support/runs.h"
#include "support/temporary_folder.h"
#include "tetraction/io/run_recorder.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

// What an observer was told; read after the solver's thread has rested.
struct Told {
  std::vector<Index> steps;
  Index started_at = -1;
  Index finished_at = -1;
  RunStatus status = RunStatus::kRunning;
};

class Listener : public Observer {
 public:
  explicit Listener(Told& told, Index throws_at = -1) : told_(told), throws_at_(throws_at) {}
  void on_start(const Session& session) override { told_.started_at = session.state().step; }
  bool on_step(const Session& session) override {
    if (session.state().step == throws_at_) throw OutputError("the disk is full");
    told_.steps.push_back(session.state().step);
    return true;
  }
  void on_finish(const Session& session) override {
    told_.finished_at = session.state().step;
    told_.status = session.status();
  }

 private:
  Told& told_;
  Index throws_at_;
};

std::unique_ptr<Simulation> spinning() {
  return simulation_of(spinning_block(Integrator::kVerlet, 1e-3, 0.1));
}

TEST(SimulationObserver, SeesTheStepsFromNowOnUntilItIsTakenAway) {
  Told told;
  const auto simulation = spinning();
  make_steps(*simulation, 3);
  EXPECT_FALSE(simulation->observed());
  simulation->observe(std::make_unique<Listener>(told));
  EXPECT_TRUE(simulation->observed());
  make_steps(*simulation, 4);
  simulation->observe(nullptr);
  make_steps(*simulation, 2);
  EXPECT_FALSE(simulation->observed());
  EXPECT_EQ(told.started_at, 3);
  EXPECT_EQ(told.steps, (std::vector<Index>{4, 5, 6, 7}));
  EXPECT_EQ(told.finished_at, 7);
  expect_no_notices(*simulation);
}

// A step that takes very long.
Scene falling_hard() {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {48, 16, 16}}, elastic(1e6, 0.4));
  scene.time = {Integrator::kMidpoint, 10.0, false, 1000.0};
  scene.environment = gravity(300.0);
  scene.solver.tolerance = 1e-13;
  scene.solver.max_iterations = 1000000;
  scene.fix.resize(1);
  scene.fix[0].select = SelectPlane{0, 0.0, {}};
  return scene;
}

TEST(SimulationObserver, IsToldOfTheEndWhenTheStepInProgressIsGivenUp) {
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kEnergyMomentum}) {
    Scene scene = falling_hard();
    scene.time.integrator = integrator;
    Told told;
    auto simulation = simulation_of(scene);
    simulation->observe(std::make_unique<Listener>(told));
    settle(*simulation);
    simulation->step();
    // The step takes tens of seconds, and it has begun by now or will not begin.
    EXPECT_FALSE(simulation->wait_until_idle(0.5));
    simulation.reset();
    EXPECT_EQ(told.started_at, 0);
    EXPECT_EQ(told.steps, std::vector<Index>{});
    EXPECT_EQ(told.finished_at, 0);
  }
}

// What a solver does that does not answer: its step waits at a gate.
struct Held {
  explicit Held(const TimeSettings& time) : gate(std::make_shared<Gate>()) {
    Scene scene = spinning_block(time.integrator, time.step, 0.1);
    const LameParameters lame = lame_from_young(1e5, 0.3);
    scene.material.custom = MaterialModel(CustomMaterial(GatedRubber(lame, gate)));
    scene.time = time;
    simulation = simulation_of(scene);
  }
  void hold_step() const {
    settle(*simulation);
    gate->close();
    simulation->step();
    ASSERT_TRUE(gate->wait_for_thread());
  }

  std::shared_ptr<Gate> gate;
  std::unique_ptr<Simulation> simulation;
};

TEST(SimulationObserver, IsToldOfTheEndAlsoIfTheSolverDoesNotAnswer) {
  Told told;
  Held held({Integrator::kMidpoint, 1e-3, false, 1000.0});
  held.simulation->observe(std::make_unique<Listener>(told));
  make_steps(*held.simulation, 3);
  held.hold_step();
  EXPECT_FALSE(held.simulation->end(0.01));
  EXPECT_EQ(told.finished_at, 3);
  EXPECT_EQ(told.status, RunStatus::kRunning);
  held.gate->open();
  held.simulation.reset();
  EXPECT_EQ(told.steps, (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(told.finished_at, 3);
}

TEST(SimulationObserver, AnAnswerInTimeIsToldToo) {
  Told told;
  const auto simulation = spinning();
  simulation->observe(std::make_unique<Listener>(told));
  make_steps(*simulation, 3);
  EXPECT_TRUE(simulation->end(60.0));
  EXPECT_EQ(told.finished_at, 3);
}

// All files of a recording; without summary and final state if the balance has parts of the step.
TEST(SimulationObserver, TheFilesOfARecordingAreCompleteThen) {
  for (const int retry : {0, 4}) {
    const TemporaryFolder folder;
    const auto path = [&](const char* name) { return (folder.path() / name).string(); };
    TimeSettings time{Integrator::kMidpoint, 1e-3, false, 1000.0};
    time.retry = retry;
    Held held(time);
    held.simulation->observe(std::make_unique<RunRecorder>(path("run"), 2));
    make_steps(*held.simulation, 5);
    held.hold_step();
    EXPECT_FALSE(held.simulation->end(0.01));
    const std::string history = read_output(path("run/history.csv"));
    EXPECT_EQ(std::ranges::count(history, '\n'), 7) << "a header and the steps 0 to 5";
    EXPECT_EQ(history.back(), '\n');
    EXPECT_TRUE(std::filesystem::exists(path("run/frames/frame_000004.vtu")));
    for (const char* name : {"run/summary.json", "run/final.vtu"}) {
      EXPECT_EQ(std::filesystem::exists(path(name)), retry == 0) << name;
    }
    held.gate->open();
    held.simulation.reset();
    EXPECT_EQ(read_output(path("run/history.csv")), history);
  }
}

TEST(SimulationObserver, EndsWithAResetAndWithTheSimulation) {
  Told first;
  Told second;
  {
    const auto simulation = spinning();
    simulation->observe(std::make_unique<Listener>(first));
    make_steps(*simulation, 5);
    simulation->reset();
    settle(*simulation);
    EXPECT_FALSE(simulation->observed());
    simulation->observe(std::make_unique<Listener>(second));
    make_steps(*simulation, 2);
  }
  EXPECT_EQ(first.finished_at, 5);
  EXPECT_EQ(second.finished_at, 2);
}

TEST(SimulationObserver, EndsWithARunThatFails) {
  Told told;
  const auto simulation = spinning();
  simulation->edit(SetTime{{Integrator::kVerlet, 1.0, false, 1000.0}}, "much too long steps");
  simulation->observe(std::make_unique<Listener>(told));
  simulation->run();
  settle(*simulation);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kUnstable);
  EXPECT_EQ(told.status, RunStatus::kUnstable);
  EXPECT_FALSE(simulation->observed());
  // Nothing to record before the way back.
  simulation->take_notices();
  simulation->observe(std::make_unique<Listener>(told));
  settle(*simulation);
  EXPECT_FALSE(simulation->observed());
  EXPECT_EQ(simulation->take_notices().size(), 1U);
}

TEST(SimulationObserver, ThatThrowsEndsWithANoticeAndTheRunGoesOn) {
  Told told;
  const auto simulation = spinning();
  simulation->observe(std::make_unique<Listener>(told, 3));
  make_steps(*simulation, 6);
  EXPECT_FALSE(simulation->observed());
  EXPECT_EQ(told.steps, (std::vector<Index>{1, 2}));
  EXPECT_EQ(told.finished_at, -1);
  EXPECT_EQ(simulation->snapshot()->step, 6);
  const std::vector<Notice> notices = simulation->take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0].text, "the disk is full");
}

}  // namespace
}  // namespace tetraction::viewer
