// The state of a session: it stays where it is in memory, and a step that fails leaves it alone.

#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <thread>

#include "support/corner_scenes.h"
#include "support/same_run.h"
#include "tetraction/core/interruption.h"

namespace tetraction {
namespace {

using namespace testing_support;

struct Addresses {
  explicit Addresses(const State& state)
      : object(&state),
        position(state.position.data()),
        momentum(state.momentum.data()),
        velocity(state.velocity.data()) {}
  bool operator==(const Addresses&) const = default;
  const State* object;
  const double* position;
  const double* momentum;
  const double* velocity;
};

void PrintTo(const Addresses& a, std::ostream* out) {
  *out << a.object << ' ' << a.position << ' ' << a.momentum << ' ' << a.velocity;
}

class SessionState : public testing::TestWithParam<RuleWithSolver> {
 protected:
  Scene make_scene() const {
    const Integrator rule = GetParam().integrator;
    Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
    scene.time = {rule, is_implicit(rule) ? 4e-3 : 2e-4, false, 10.0};
    scene.solver = GetParam().solver;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.damping = {0.3, 0.2, 20.0};
    return scene;
  }
};

INSTANTIATE_TEST_SUITE_P(All, SessionState, testing::ValuesIn(rules_with_solvers()),
                         name_with_solver);

TEST_P(SessionState, KeepsItsAddressesAndLookingChangesNothing) {
  const Scene scene = make_scene();
  Session session(scene, mesh_of(scene));
  Session watched(scene, mesh_of(scene));
  const Addresses home(session.state());
  const auto stay = [&] { EXPECT_EQ(Addresses(session.state()), home); };
  const auto steps = [&](int count) {
    for (int k = 0; k < count; ++k) {
      ASSERT_TRUE(session.step()) << session.message();
      ASSERT_TRUE(watched.step()) << watched.message();
      EXPECT_EQ(watched.state().step, session.step_number());
      EXPECT_EQ(watched.state().time, session.time());
    }
    stay();
    expect_same(session, watched);
  };
  // Each edit is made once at a state that nobody has looked at, and once at another one.
  const auto edit = [&](const Edit& what) {
    ASSERT_TRUE(session.step()) << session.message();
    ASSERT_TRUE(watched.step()) << watched.message();
    session.apply(what);
    watched.state();
    watched.apply(what);
    stay();
    expect_same(session, watched);
    steps(1);
  };
  for (const int count : {1, 2, 3}) steps(count);

  FixSettings fix = moving(SelectPlane{0, 2.0, {}}, {0.0, 0.1, 0.0});
  fix.offset = Vector3(0.01, 0.0, 0.0);
  edit(SetFix{{}, fix});
  ConstraintSettings distance = rod(16, 28, 1.1);
  edit(SetConstraint{{}, distance});
  edit(RemoveConstraint{0});
  ShiftSettings shift{{16, 17}, {{0.001, 0, 0}, {0, 0.001, 0}}, {}, {}};
  edit(ShiftState{shift});
  edit(SetMomentum{{SelectVertices{{16}}, {0.0, 1.0, 0.0}, {}}});
  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 5e5;
  edit(SetMaterial{0, softer});
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kBackwardEuler,
                                Integrator::kExplicit, Integrator::kMidpoint}) {
    edit(SetTime{{rule, is_implicit(rule) ? 4e-3 : 2e-4, false, 10.0}});
  }
  steps(3);

  shift.displacement = {{100.0, 0, 0}, {0, 0, 0}};
  EXPECT_THROW(session.apply(ShiftState{shift}), InputError);
  stay();
  expect_same(session, watched);

  const Checkpoint checkpoint = session.checkpoint();
  watched.checkpoint();
  steps(3);
  session.restore(checkpoint);
  watched.restore(checkpoint);
  stay();
  steps(2);
}

TEST_P(SessionState, StaysWhereItIsWhenStepsFailAndAfterwards) {
  Scene scene = make_scene();
  if (is_implicit(GetParam().integrator)) {
    scene.solver.max_iterations = 1;
    scene.solver.tolerance = 1e-14;
  } else {
    scene.time.step = 0.05;  // far above the limit
  }
  Session session(scene, mesh_of(scene));
  const Addresses home(session.state());
  session.keep_good_states();
  while (session.step()) {
  }
  EXPECT_NE(session.status(), RunStatus::kFinished);
  EXPECT_EQ(Addresses(session.state()), home);
  EXPECT_TRUE(session.state().position.allFinite());
  session.go_back();
  EXPECT_EQ(Addresses(session.state()), home);
  scene = make_scene();
  session.apply(SetSolver{scene.solver});
  session.apply(SetTime{scene.time});
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(session.step()) << session.message();
  EXPECT_EQ(Addresses(session.state()), home);
}

// A step that "auto" makes again begins at the state that was there before.
TEST(SessionStateWithAuto, IsNotLostWhenAStepIsMadeAgain) {
  Scene scene = clamped_beam({1, 1, 1}, {4, 4, 4});
  scene.time = {Integrator::kVerlet, 0.0, true, 0.004};
  scene.fix.push_back(moving(SelectPlane{0, 1.0, {}}, {-80.0, 0.0, 0.0}));
  Session session(scene, mesh_of(scene));
  Session watched(scene, mesh_of(scene));
  const Addresses home(session.state());
  while (session.step()) {
    ASSERT_TRUE(watched.step());
    ASSERT_EQ(watched.state().step, session.step_number());
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(session.steps().changes, 0);
  watched.step();
  EXPECT_EQ(Addresses(session.state()), home);
  expect_same(session, watched);
}

// A step that "auto" repeats because of its energy error is the same as a first one of that size.
TEST(SessionStateWithAuto, LeadsToWhereASingleStepOfThatSizeLeads) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    Scene scene = scene_of({GeneratorKind::kBox, {1, 1, 1}, {2, 2, 2}}, elastic(1e6, 0.4));
    scene.initial.stretch = {1.3, 1.3, 1.3};
    scene.damping.viscosity = 20.0;
    scene.time = {rule, 0.0, true, 0.2};
    Session session(scene, mesh_of(scene));
    State state = session.state();
    double dissipated = 0.0;
    while (session.step()) {
      const StepOutcome outcome = make_stepper(rule, session.system(), nullptr)
                                      ->step_to(state, session.steps().last, session.time());
      ASSERT_TRUE(outcome.ok());
      ASSERT_EQ(state.position, session.state().position) << "step " << state.step;
      ASSERT_EQ(state.momentum, session.state().momentum) << "step " << state.step;
      dissipated += outcome.dissipated_energy;
      ASSERT_EQ(session.balance().dissipated_energy(), dissipated) << "step " << state.step;
    }
    EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_GT(session.steps().changes, 0);
  }
}

TEST(SessionState, ManyThreadsMayLookAtOnce) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 10.0);
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(session.step());
    const Session& seen = session;
    std::vector<std::thread> threads;
    std::atomic<int> wrong{0};
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        if (seen.state().step != seen.step_number() || seen.state().time != seen.time()) ++wrong;
      });
    }
    for (std::thread& thread : threads) thread.join();
    ASSERT_EQ(wrong, 0);
  }
}

// Throws at one of its calls, or does something else.
class Thrower : public VertexPotential {
 public:
  explicit Thrower(
      std::shared_ptr<std::atomic<int>> calls_left,
      std::function<void()> act = [] { throw std::runtime_error("the thrower throws"); })
      : left_(std::move(calls_left)), act_(std::move(act)) {}
  std::string name() const override { return "thrower"; }
  double value(double mass, const Vector3& x) const override {
    count();
    return 0.5 * mass * x.squaredNorm();
  }
  Vector3 gradient(double mass, const Vector3& x) const override {
    count();
    return mass * x;
  }
  Matrix3 hessian(double mass, const Vector3& /*x*/) const override {
    count();
    return mass * Matrix3::Identity();
  }

 private:
  void count() const {
    if (--*left_ == 0) act_();
  }
  std::shared_ptr<std::atomic<int>> left_;
  std::function<void()> act_;
};

class Throwing : public SessionState {
 protected:
  std::shared_ptr<std::atomic<int>> left_ = std::make_shared<std::atomic<int>>(-1);
  Scene throwing_scene() const {
    Scene scene = make_scene();
    scene.force_term.push_back(std::make_shared<Thrower>(left_));
    return scene;
  }
};

INSTANTIATE_TEST_SUITE_P(All, Throwing, testing::ValuesIn(rules_with_solvers()), name_with_solver);

TEST_P(Throwing, StepsLeaveStateAndBalanceAsTheyWereAndCanBeMadeAgain) {
  const Scene scene = throwing_scene();
  Session session(scene, mesh_of(scene));
  Session twin(scene, mesh_of(scene));
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(session.step()) << session.message();
    ASSERT_TRUE(twin.step());
  }
  const State before = session.state();
  const std::vector<double> balance = numbers_of(session.balance().sums());
  twin.checkpoint();  // it forgets earlier steps, as a step does that threw
  *left_ = 1'000'000'000;
  ASSERT_TRUE(twin.step());
  const int calls = 1'000'000'000 - *left_;
  // Among the first calls, in the middle, and the last ones, which are those of the balance.
  for (const int call : {1, calls / 3, calls / 2, calls - 1, calls}) {
    *left_ = call;
    EXPECT_THROW(session.step(), std::runtime_error) << call << " of " << calls;
    *left_ = -1;
    EXPECT_EQ(session.status(), RunStatus::kRunning);
    EXPECT_EQ(session.state().step, before.step);
    EXPECT_EQ(session.state().position, before.position);
    EXPECT_EQ(session.state().momentum, before.momentum);
    EXPECT_EQ(session.state().velocity, before.velocity);
    EXPECT_EQ(numbers_of(session.balance().sums()), balance);
  }
  ASSERT_TRUE(session.step()) << session.message();
  EXPECT_EQ(session.state().position, twin.state().position);
  EXPECT_EQ(session.state().momentum, twin.state().momentum);
  EXPECT_EQ(numbers_of(session.balance().sums()), numbers_of(twin.balance().sums()));
}

TEST(ThrowingEquilibrium, LoadStepsCanBeMadeAgain) {
  const auto left = std::make_shared<std::atomic<int>>(-1);
  Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.force_term.push_back(std::make_shared<Thrower>(left));
  Session session(scene, mesh_of(scene), Analysis::kEquilibrium, 0.5);
  ASSERT_TRUE(session.step()) << session.message();
  const State before = session.state();
  const double error = session.constraint_error();
  *left = 50;
  EXPECT_THROW(session.step(), std::runtime_error);
  *left = -1;
  EXPECT_EQ(session.state().position, before.position);
  EXPECT_EQ(session.constraint_error(), error);
  ASSERT_TRUE(session.step()) << session.message();
  EXPECT_EQ(session.status(), RunStatus::kFinished);
}

TEST_P(Throwing, StepsThatAreInterruptedEndSoonAndCanBeMadeAgain) {
  std::atomic<bool> stop{false};
  Scene scene = make_scene();
  scene.force_term.push_back(std::make_shared<Thrower>(left_, [&stop] { stop = true; }));
  Session session(scene, mesh_of(scene));
  Session twin(scene, mesh_of(scene));
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(session.step()) << session.message();
    ASSERT_TRUE(twin.step());
  }
  const State before = session.state();
  twin.checkpoint();  // it forgets earlier steps, as a step does that was interrupted
  constexpr int kMany = 1'000'000'000;
  *left_ = kMany;
  ASSERT_TRUE(twin.step());
  const int calls = kMany - *left_;
  const auto vertices = static_cast<int>(session.system().vertex_count());
  for (const int call : {1, calls / 3, calls / 2}) {
    {
      const Interruptible interruptible(stop);
      *left_ = call;
      EXPECT_THROW(session.step(), Interrupted) << call << " of " << calls;
      // At most the rest of the loop over the vertices, or of all loops without one that can end.
      EXPECT_GT(*left_, -4 * vertices) << call << " of " << calls;
    }
    stop = false;
    *left_ = -1;
    EXPECT_EQ(session.status(), RunStatus::kRunning);
    EXPECT_EQ(session.state().step, before.step);
    EXPECT_EQ(session.state().position, before.position);
    EXPECT_EQ(session.state().momentum, before.momentum);
  }
  ASSERT_TRUE(session.step()) << session.message();
  EXPECT_EQ(session.state().position, twin.state().position);
  EXPECT_EQ(session.state().momentum, twin.state().momentum);
}

TEST_P(Throwing, RunsTellTheirObserversAndPassTheExceptionOn) {
  struct Witness : Observer {
    bool on_step(const Session& session) override {
      if (session.step_number() == 2) *left = 5;
      return true;
    }
    void on_finish(const Session& session) override {
      ++finished;
      step = session.state().step;
      status = session.status();
      message = session.message();
    }
    std::shared_ptr<std::atomic<int>> left;
    int finished = 0;
    Index step = -1;
    RunStatus status = RunStatus::kRunning;
    std::string message;
  };
  struct Bad : Observer {
    void on_finish(const Session&) override { throw OutputError("a full disk"); }
  };
  const Scene scene = throwing_scene();
  Session session(scene, mesh_of(scene));
  Bad bad;
  Witness witness;
  witness.left = left_;
  EXPECT_THROW(session.run({&bad, &witness}), std::runtime_error);
  EXPECT_EQ(witness.finished, 1);
  EXPECT_EQ(witness.step, 2);
  EXPECT_EQ(witness.status, RunStatus::kNotConverged);
  EXPECT_NE(witness.message.find("the thrower throws"), std::string::npos) << witness.message;
  session.go_back();
  EXPECT_TRUE(session.step()) << session.message();
}

}  // namespace
}  // namespace tetraction
