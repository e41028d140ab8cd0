// Checkpoints: the run that made one and a run that is restored from it go on with the same bits.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "support/corner_scenes.h"
#include "support/force_terms.h"
#include "support/same_run.h"
#include "tetraction/simulation/checkpoint_observer.h"

namespace tetraction {
namespace {

using namespace testing_support;

double step_of(Integrator rule) {
  return is_implicit(rule) ? 4e-3 : 2e-4;
}

// Gravity, damping, a face that is held, another one that moves, a distance, and an event after
// step 12 that changes most settings.
Scene busy_scene(const RuleWithSolver& way) {
  Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
  const double h = step_of(way.integrator);
  scene.time = {way.integrator, h, false, 60 * h};
  scene.solver = way.solver;
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.damping = {0.3, 0.2, 20.0};
  FixSettings moving = testing_support::moving(SelectPlane{0, 2.0, {}}, {0.02, 0.1, 0.0});
  scene.fix.push_back(moving);
  scene.constraint.push_back(rod(16, 28));
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 0.8e6;
  moving.velocity = {-0.05, 0.2, 0.1};
  scene.event.push_back({12.0 * h,
                         {SetMaterial{0, softer}, SetFix{1, moving}, SetDamping{{0.1, 0.4, 30.0}}},
                         {},
                         {}});
  return scene;
}

ForceSettings pull() {
  return load(SelectVertices{{22, 23}}, {2.0, 5.0, -3.0});
}

void make_steps(Session& session, int count) {
  for (int k = 0; k < count; ++k) ASSERT_TRUE(session.step()) << session.message();
}

class Checkpoints : public testing::TestWithParam<RuleWithSolver> {};

TEST_P(Checkpoints, ContinuedAndRestoredRunsHaveTheSameBits) {
  const Scene scene = busy_scene(GetParam());
  Session continued(scene, mesh_of(scene));
  make_steps(continued, 4);
  continued.apply(SetForce{{}, pull()}, "pull");
  make_steps(continued, 4);
  const Vector reaction = continued.reaction_force();
  const Checkpoint checkpoint = continued.checkpoint();
  EXPECT_EQ(continued.edits().size(), 1U) << "no entry of its own";
  EXPECT_EQ(continued.reaction_force(), reaction);
  EXPECT_EQ(checkpoint.state.step, 8);

  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  expect_same(continued, restored);
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(continued.step()) << continued.message();
    ASSERT_TRUE(restored.step()) << restored.message();
    ASSERT_EQ(continued.state().position, restored.state().position) << k;
  }
  EXPECT_EQ(continued.edits().size(), 2U) << "the event was made";
  expect_same(continued, restored);

  // Back in time, past the event, which happens again.
  continued.restore(checkpoint);
  EXPECT_EQ(continued.state().position, checkpoint.state.position);
  EXPECT_EQ(continued.materials()[0].youngs_modulus, scene.material.youngs_modulus);
  EXPECT_EQ(continued.damping().viscosity, 20.0);
  EXPECT_EQ(continued.forces().size(), 1U);
  make_steps(continued, 20);
  expect_same(continued, restored);
}

INSTANTIATE_TEST_SUITE_P(All, Checkpoints, testing::ValuesIn(rules_with_solvers()),
                         name_with_solver);

class AutomaticCheckpoints : public testing::TestWithParam<Integrator> {};

// The limit falls all the time, so that its estimates, their modes and the schedule count.
TEST_P(AutomaticCheckpoints, ContinuedAndRestoredRunsHaveTheSameBits) {
  Scene scene = clamped_beam({0.4, 0.1, 0.1}, {8, 2, 2});
  scene.time = {GetParam(), 0.0, true, 0.1};
  scene.damping.viscosity = 5.0;
  scene.fix.push_back(moving(SelectPlane{0, 0.4, {}}, {-2.0, 0.0, 0.0}));
  scene.event.push_back({0.05, {SetDamping{{0.0, 0.0, 10.0}}}, "{}", "event.0"});
  Session continued(scene, mesh_of(scene));
  make_steps(continued, 10);
  continued.apply(SetForce{{}, pull()});
  make_steps(continued, 40);
  ASSERT_LT(continued.state().time, 0.05);
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  while (continued.step()) ASSERT_TRUE(restored.step()) << restored.message();
  EXPECT_FALSE(restored.step());
  EXPECT_EQ(continued.status(), RunStatus::kFinished) << continued.message();
  EXPECT_EQ(continued.edits().size(), 2U);
  EXPECT_GT(continued.steps().changes, checkpoint.progress.steps.changes);
  expect_same(continued, restored);
}

// A body at rest that is thrown at a floor comes into its layer sooner than the forecast of the limit says. Both runs
// look at the layer again after the checkpoint.
TEST_P(AutomaticCheckpoints, HaveTheSameStepsBesideAnObstacle) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {3, 3, 3}}, elastic(1e5, 0.4));
  scene.time = {GetParam(), 1e-3, true, 0.5};
  ObstacleSettings floor;
  floor.name = "floor";
  const double thickness = 7e-3;
  floor.thickness = thickness;
  floor.point = {0.0, -2.1 * thickness, 0.0};
  scene.obstacle.push_back(floor);
  const double step = Session(scene, mesh_of(scene)).time_step();
  // In 16 steps, for which the forecast is valid, it falls by 1.6 layers.
  scene.environment = gravity(3.2 * thickness / (256.0 * step * step));
  Session continued(scene, mesh_of(scene));
  make_steps(continued, 14);
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  make_steps(continued, 40);
  make_steps(restored, 40);
  EXPECT_GT(continued.balance().sums().obstacles[0].linear.y(), 0.0);
  EXPECT_LT(continued.time_step(), step);
  expect_same(continued, restored);
}

INSTANTIATE_TEST_SUITE_P(Rules, AutomaticCheckpoints,
                         testing::Values(Integrator::kVerlet, Integrator::kExplicit),
                         [](const auto& test) { return to_string(test.param); });

class AdaptiveCheckpoints : public testing::TestWithParam<TimeSettings> {};

// The controllers remember errors, energies and works of earlier steps.
TEST_P(AdaptiveCheckpoints, ContinuedAndRestoredRunsHaveTheSameBits) {
  RuleWithSolver way;
  way.integrator = GetParam().integrator;
  Scene scene = busy_scene(way);
  scene.time = GetParam();
  scene.event[0].at = 0.7 * scene.time.end;
  if (scene.time.retry > 0) {
    scene.solver.max_iterations = 2;
    ForceSettings blow = pull();
    blow.vector *= 1e5;
    blow.from = 0.3 * scene.time.end;
    scene.force.push_back(blow);
  }
  Session continued(scene, mesh_of(scene));
  while (continued.time() < 0.4 * scene.time.end) {
    ASSERT_TRUE(continued.step()) << continued.message();
  }
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  expect_same(continued, restored);
  while (continued.step()) ASSERT_TRUE(restored.step()) << restored.message();
  EXPECT_FALSE(restored.step());
  EXPECT_EQ(continued.status(), RunStatus::kFinished) << continued.message();
  EXPECT_EQ(continued.edits().size(), 1U) << "the event was made";
  expect_same(continued, restored);
  const StepControl& a = continued.step_control();
  const StepControl& b = restored.step_control();
  EXPECT_EQ(a.retried, b.retried);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.without_solution, b.without_solution);
  EXPECT_EQ(a.last_error, b.last_error);
  EXPECT_EQ(a.discrete_energy, b.discrete_energy);
  if (scene.time.retry > 0) {
    EXPECT_GT(a.retried, 0);
  } else {
    EXPECT_GT(continued.steps().changes, checkpoint.progress.steps.changes);
  }
}

std::vector<TimeSettings> adaptive_settings() {
  std::vector<TimeSettings> all;
  for (const Integrator rule : all_integrators()) {
    TimeSettings time{rule, step_of(rule), false, 60 * step_of(rule)};
    time.adapt = StepAdaptation::kError;
    time.tolerance = 1e-5;
    all.push_back(time);
    if (!is_implicit(rule) || !is_variational(rule)) continue;
    time = {rule, step_of(rule), false, 60 * step_of(rule)};
    time.retry = 8;
    all.push_back(time);
    time.retry = 0;
    time.adapt = StepAdaptation::kEnergy;
    all.push_back(time);
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Modes, AdaptiveCheckpoints, testing::ValuesIn(adaptive_settings()),
                         [](const auto& test) {
                           std::string name =
                               to_string(test.param.integrator) +
                               (test.param.retry > 0 ? "_retry"
                                                     : "_by_" + to_string(test.param.adapt));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Checkpoint, KeepsWhatEditsChangedInTheConstraints) {
  RuleWithSolver way;
  way.integrator = Integrator::kVerlet;
  const Scene scene = busy_scene(way);
  Session session(scene, mesh_of(scene));
  make_steps(session, 3);
  session.apply(Unfix{SelectVertices{{0, 1}}, "", {}});
  ConstraintSettings rigid = testing_support::rigid(SelectVertices{{17, 18, 21, 22, 23}});
  session.apply(SetConstraint{{}, rigid});
  session.apply(RemoveConstraint{0});
  make_steps(session, 3);
  const Checkpoint checkpoint = session.checkpoint();
  Session restored(scene, mesh_of(scene));
  restored.restore(checkpoint);
  ASSERT_EQ(restored.constraints().size(), 2U);
  EXPECT_FALSE(restored.constraints()[0].has_value());
  EXPECT_EQ(restored.fix(0).vertices, session.fix(0).vertices);
  EXPECT_EQ(restored.fix(1).targets, session.fix(1).targets);
  make_steps(session, 20);
  make_steps(restored, 20);
  expect_same(session, restored);
}

// A run that ended stays ended, one that failed can go back, and the checkpoint needs no session.
TEST(Checkpoint, HasTheStatusOfTheRun) {
  Scene scene = spinning_block(Integrator::kMidpoint, 1e-2, 0.1);
  Checkpoint finished;
  Checkpoint failed;
  {
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished);
    finished = session.checkpoint();
    Session other(scene, mesh_of(scene));
    make_steps(other, 3);
    other.apply(SetSolver{{"newton", LinearSolver::kAuto, 1e-13, 1}});
    ASSERT_FALSE(other.step());
    failed = other.checkpoint();
  }
  Session session(scene, mesh_of(scene));
  session.keep_good_states();
  session.restore(finished);
  EXPECT_EQ(session.status(), RunStatus::kFinished);
  EXPECT_EQ(session.state().time, 0.1);
  EXPECT_FALSE(session.step());
  session.restore(failed);
  EXPECT_EQ(session.status(), RunStatus::kNotConverged);
  EXPECT_FALSE(session.message().empty());
  session.go_back();
  EXPECT_EQ(session.state().step, 3);
  session.apply(SetSolver{scene.solver});
  make_steps(session, 3);
}

// Stores the steps of the checkpoints of a run, which it stops after a step.
class CheckpointCollector : public Observer, public CheckpointObserver {
 public:
  CheckpointCollector(Index every, Index stop_at) : every_(every), stop_at_(stop_at) {}
  bool on_step(const Session& session) override { return session.step_number() != stop_at_; }
  Index checkpoint_every() const override { return every_; }
  void on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                     bool is_regular) override {
    EXPECT_EQ(checkpoint.state.step, session.step_number());
    (is_regular ? regular : stopped).push_back(checkpoint.state.step);
  }
  std::vector<Index> regular;
  std::vector<Index> stopped;

 private:
  Index every_;
  Index stop_at_;
};

TEST(Checkpoint, ObserversGetThemWhileARunGoesOn) {
  const Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.02);
  using Steps = std::vector<Index>;
  const auto run = [&](Index every, Index stop_at) {
    Session session(scene, mesh_of(scene));
    CheckpointCollector collector(every, stop_at);
    session.run({&collector});
    return std::pair(collector.regular, collector.stopped);
  };
  EXPECT_EQ(run(5, 100), std::pair(Steps({5, 10, 15}), Steps())) << "none at the end of the run";
  EXPECT_EQ(run(5, 12), std::pair(Steps({5, 10}), Steps({12})));
  EXPECT_EQ(run(5, 10), std::pair(Steps({5, 10}), Steps())) << "one is enough";
  EXPECT_EQ(run(0, 12), std::pair(Steps(), Steps({12})));
  EXPECT_EQ(run(0, 100), std::pair(Steps(), Steps()));
  EXPECT_EQ(run(-1, 12), std::pair(Steps(), Steps()));
}

// A blow-up after a restored checkpoint never leads back to a good state of another time.
TEST(Checkpoint, IsAGoodStateOnceItIsRestored) {
  Scene scene = spinning_block(Integrator::kExplicit, 1e-3, 100.0);
  Session session(scene, mesh_of(scene));
  session.keep_good_states();
  make_steps(session, 20);
  const Checkpoint checkpoint = session.checkpoint();
  make_steps(session, 300);
  session.restore(checkpoint);
  TimeSettings coarse = scene.time;
  coarse.step = 1.2 * session.current_limit().critical_step;
  session.apply(SetTime{coarse});
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kUnstable);
  session.go_back();
  EXPECT_GE(session.state().step, 20);
  EXPECT_LT(session.state().step, 300);
}

TEST(Checkpoint, RefusedOnesLeaveTheSessionAsItWas) {
  RuleWithSolver way;
  way.integrator = Integrator::kVerlet;
  const Scene scene = busy_scene(way);
  Session session(scene, mesh_of(scene));
  Session twin(scene, mesh_of(scene));
  make_steps(session, 5);
  make_steps(twin, 5);
  const Checkpoint good = session.checkpoint();
  twin.checkpoint();  // so that both begin with the same multipliers

  const auto refuses = [&](const Checkpoint& wrong, const char* part) {
    expect_error([&] { session.restore(wrong); }, {part});
    expect_same(session, twin);
  };
  const auto changed = [&](const std::function<void(Checkpoint&)>& change) {
    Checkpoint wrong = good;
    change(wrong);
    return wrong;
  };
  const auto empty = std::make_unique<Checkpoint>();
  refuses(*empty, "another body");
  refuses(changed([](Checkpoint& c) { c.state.momentum.resize(3); }), "not complete");
  refuses(changed([](Checkpoint& c) { c.state.position[4] = std::nan(""); }), "finite");
  refuses(changed([](Checkpoint& c) { c.settings.materials.clear(); }), "not complete");
  refuses(changed([](Checkpoint& c) { c.settings.constraints.fixes.pop_back(); }), "[[fix]]");
  refuses(changed([](Checkpoint& c) { c.settings.constraints.others.clear(); }), "[[constraint]]");
  refuses(changed([](Checkpoint& c) { c.settings.materials[0].model = "wood"; }), "wood");
  refuses(changed([](Checkpoint& c) { c.settings.damping.drag = -1.0; }), "damping.drag");
  refuses(changed([](Checkpoint& c) {
            ForceSettings nowhere;
            nowhere.select = SelectVertices{{999}};
            c.settings.loads.force.push_back(nowhere);
          }),
          "999");
  refuses(changed([](Checkpoint& c) { c.progress.next_event = 2; }), "events");
  refuses(changed([](Checkpoint& c) {  // a vertex prescribed twice, in two ways
            c.settings.constraints.fixes.push_back(c.settings.constraints.fixes[1]);
            c.settings.constraints.fixes.back().start.array() += 0.1;
            c.settings.materials[0].youngs_modulus = 7e6;
          }),
          "");
  // Bodies with as many vertices, which differ in a corner, a density, or a force term.
  Scene other = scene;
  other.mesh.generate->size.x() = 2.5;
  other.fix[1].select = SelectPlane{0, 2.5, {}};
  other.event.clear();
  refuses(Session(other, mesh_of(other)).checkpoint(), "differs in the mesh (");
  other = scene;
  other.material.density = 999.0;
  other.event.clear();
  refuses(Session(other, mesh_of(other)).checkpoint(), "differs in the densities (");
  other = scene;
  other.force_term.push_back(std::make_shared<QuadraticDrag>(0.1));
  refuses(Session(other, mesh_of(other)).checkpoint(), "differs in the names of the force terms (");

  // Refused last, when the system has the other materials, forces and constraints already.
  refuses(changed([](Checkpoint& c) {
            c.settings.materials[0].youngs_modulus = 7e6;
            c.settings.damping = {};
            c.settings.loads.force.push_back(pull());
            c.settings.constraints.fixes[1].start.array() += 0.1;
            c.settings.time.integrator = Integrator::kMidpoint;
            c.settings.solver.kind = "none";
          }),
          "solver");

  make_steps(session, 20);
  make_steps(twin, 20);
  expect_same(session, twin);
}

}  // namespace
}  // namespace tetraction
