// Runs that are stopped in the middle of a step.
#include "tetraction/simulation/stop_request.h"

#include <atomic>
#include <string>

#include "support/runs.h"
#include "tetraction/simulation/stop_flag.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Wants the run to stop when it is asked for the third time within a step.
class ThirdQuestion : public Observer, public StopRequest {
 public:
  bool on_step(const Session& session) override {
    last = session.state();
    questions = 0;
    return true;
  }
  bool stop_requested() const override { return ++questions == 3; }
  State last;
  mutable int questions = 0;
};

// From 0.2 s on its solver does not converge, whatever the step.
Scene pulled_beam() {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {4, 1, 1}}, elastic(1e5, 0.4));
  scene.time = {Integrator::kMidpoint, 0.05, false, 1.0};
  scene.solver.tolerance = 1e-12;
  scene.solver.max_iterations = 1;
  scene.fix.resize(1);
  scene.fix[0].select = SelectPlane{0, 0.0, {}};
  ForceSettings force = total_load(SelectPlane{0, 4.0, {}}, {0.0, 6e4, 0.0});
  force.from = 0.2;
  scene.force.push_back(force);
  return scene;
}

void expect_stopped_within_step(const Scene& scene) {
  Session session(scene, generate_mesh(*scene.mesh.generate));
  ThirdQuestion observer;
  ASSERT_EQ(session.run({&observer}), RunStatus::kCancelled) << session.message();
  EXPECT_EQ(observer.questions, 3);
  expect_part(session.message(), "in the middle of the next one");
  EXPECT_GT(session.step_number(), 0);
  EXPECT_EQ(session.step_number(), observer.last.step);
  EXPECT_EQ(session.time(), observer.last.time);
  EXPECT_EQ(session.state().position, observer.last.position);
  EXPECT_EQ(session.state().momentum, observer.last.momentum);
  EXPECT_EQ(session.balance().external_work(), 0.0);
  EXPECT_FALSE(session.step());
}

TEST(StopRequest, IsHeardBetweenThePartsOfAStep) {
  Scene scene = pulled_beam();
  scene.time.retry = 30;
  expect_stopped_within_step(scene);
}

TEST(StopRequest, IsHeardBetweenTheAttemptsAtAStep) {
  Scene scene = pulled_beam();
  scene.time.max_step = 0.05;
  for (const StepAdaptation adaptation : {StepAdaptation::kError, StepAdaptation::kEnergy}) {
    scene.time.adapt = adaptation;
    SCOPED_TRACE(to_string(adaptation));
    expect_stopped_within_step(scene);
  }
}

// Is set from the start, or after a load step.
class Flag : public Observer, public StopRequest, public StopFlag {
 public:
  explicit Flag(Index after) : after_(after), flag_(after == 0) {}
  bool on_step(const Session& session) override {
    if (session.step_number() == after_) flag_ = true;
    return true;
  }
  void on_finish(const Session& session) override {
    // Observers can compute, although the load steps cannot.
    Vector densities;
    session.system().elastic().energy_densities(session.state().position, densities);
    finished = densities.size() > 0;
  }
  bool stop_requested() const override { return flag_; }
  const std::atomic<bool>& stop_flag() const override { return flag_; }
  bool finished = false;

 private:
  Index after_;
  std::atomic<bool> flag_;
};

TEST(StopRequest, GivesUpALoadStep) {
  Scene scene = pulled_beam();
  scene.solver = SolverSettings{};
  scene.force[0].total = Vector3(0.0, 10.0, 0.0);
  scene.force[0].from = 0.0;
  for (const Index steps : {0, 2}) {
    Session session(scene, generate_mesh(*scene.mesh.generate), Analysis::kEquilibrium, 0.25);
    Flag flag(steps);
    ASSERT_EQ(session.run({&flag}), RunStatus::kCancelled) << session.message();
    EXPECT_EQ(session.step_number(), steps);
    EXPECT_EQ(session.time(), 0.25 * static_cast<double>(steps));
    EXPECT_TRUE(session.state().position.allFinite());
    EXPECT_TRUE(flag.finished);
    EXPECT_NE(session.message().find("load factor"), std::string::npos) << session.message();
  }
}

}  // namespace
}  // namespace tetraction
