// Corners of stepping: "auto" where the limit falls, ends that the step does not divide, elements turned
// inside out, and what a user is told of results that mislead.

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "support/corner_scenes.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/simulation/study.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A cube whose far face is driven at 0.5 m/s into the one that is held.
Scene press(const std::array<int, 3>& cells, double end) {
  Scene scene = scene_of({GeneratorKind::kCube, {1, 1, 1}, cells}, elastic(1e6, 0.45));
  scene.damping.viscosity = 100.0;
  scene.time = {Integrator::kVerlet, 0.0, true, end};
  scene.fix.resize(2);
  scene.fix[0].select = SelectPlane{0, 0.0, {}};
  scene.fix[1].select = SelectPlane{0, 1.0, {}};
  scene.fix[1].velocity = {-0.5, 0.0, 0.0};
  return scene;
}

TEST(AutomaticStepping, GoesOnUntilACubeIsCrushed) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    Scene scene = press({4, 4, 4}, 10.0);
    scene.time.integrator = rule;
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kUnstable);
    EXPECT_GT(session.state().time, 1.4);  // with the first step it was 1.195 s
    EXPECT_LE(session.state().time, 2.0);
    EXPECT_NE(session.message().find("crushed"), std::string::npos) << session.message();
    EXPECT_NE(session.message().find("element"), std::string::npos);
    EXPECT_EQ(session.message().find("auto"), std::string::npos) << "which is in force";
    EXPECT_LT(session.steps().smallest, 1e-3 * session.steps().largest);
    EXPECT_GT(session.steps().changes, 10);
    EXPECT_LT(session.balance().max_relative_energy_drift(),
              rule == Integrator::kVerlet ? 0.02 : 0.2);
  }
}

// A bar that is pressed to a quarter of its length: between two estimates at fixed intervals the limit
// would fall far below the step, and the integrator would add a twentieth of the energy and more.
TEST(AutomaticStepping, FollowsABarThatIsPressedTogether) {
  for (const double speed : {1.2, 5.0}) {
    Scene scene = scene_of({GeneratorKind::kBeam, {0.4, 0.1, 0.1}, {8, 2, 2}}, elastic(1e6, 0.3));
    scene.time = {Integrator::kVerlet, 0.0, true, 0.36 / speed};
    scene.fix.resize(2);
    scene.fix[0].select = SelectPlane{0, 0.0, {}};
    scene.fix[1].select = SelectPlane{0, 0.4, {}};
    scene.fix[1].velocity = {-speed, 0.0, 0.0};
    FinishedRun session(scene);
    EXPECT_LT(session.balance().max_relative_energy_drift(), 0.01) << speed;
  }
}

TEST(AutomaticStepping, FollowsAnEventThatStiffensTheBody) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    Scene scene = spinning_block(rule, 0.0, 1.0);
    scene.time.automatic = true;
    MaterialSettings stiff = scene.material;
    stiff.youngs_modulus = 100.0 * *stiff.youngs_modulus;
    scene.event.push_back({0.3, {SetMaterial{0, stiff}}, "{}", "event.0"});
    scene.event.push_back({0.6, {SetMaterial{0, scene.material}}, "{}", "event.1"});
    Session session(scene, mesh_of(scene));
    const double first = session.time_step();
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_EQ(session.state().time, 1.0);
    EXPECT_NEAR(session.steps().smallest, 0.1 * first, 0.02 * first);
    EXPECT_GT(session.time_step(), 0.7 * first);
    for (const AppliedEdit& edit : session.edits()) EXPECT_TRUE(edit.warning.empty());
    // It is of first order with the explicit rule, and another one for another step.
    EXPECT_LT(session.balance().max_relative_energy_drift(),
              rule == Integrator::kVerlet ? 0.05 : 0.3);
    EXPECT_LT(session.balance().linear_momentum_drift(), 1e-11);
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-11);
  }
}

// The step is the same all the time where a body merely swings: the energy error then has no drift.
TEST(AutomaticStepping, DoesNotChangeTheStepOfABodyThatSwings) {
  Scene scene = spinning_block(Integrator::kVerlet, 0.0, 20.0);
  scene.time.automatic = true;
  Session session(scene, mesh_of(scene));
  ASSERT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_LE(session.steps().changes, 1);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.02);
}

// A blow so hard that the first elements are crushed within a few steps: they are made again, smaller.
TEST(AutomaticStepping, MakesAStepAgainThatWasTooLarge) {
  Scene scene = press({4, 4, 4}, 0.004);
  scene.damping.viscosity = 0.0;
  scene.fix[1].velocity = {-80.0, 0.0, 0.0};
  FinishedRun session(scene);
  EXPECT_EQ(session.state().time, 0.004);
  EXPECT_GT(session.steps().changes, 0);
}

// A box that is stretched by 30 % and let go: its elements are pressed together within a few steps. Single
// steps would change the energy by more than half.
TEST(AutomaticStepping, ResolvesAViolentMotion) {
  for (const double ratio : {0.3, 0.4, 0.45}) {
    for (const int cells : {1, 2, 3}) {
      Scene scene =
          scene_of({GeneratorKind::kBox, {1, 1, 1}, {cells, cells, cells}}, elastic(1e6, ratio));
      scene.initial.stretch = {1.3, 1.3, 1.3};
      scene.time = {Integrator::kVerlet, 0.0, true, 1.0};
      Session session(scene, mesh_of(scene));
      double before = 0.0;
      double most = 0.0;
      while (session.step()) {
        most = std::max(most, std::abs(session.balance().energy_error() - before));
        before = session.balance().energy_error();
      }
      EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
      EXPECT_LE(most, 0.05 * session.balance().energy_scale()) << ratio << ' ' << cells;
      // The motion is chaotic. In 36 such boxes the error was 4 to 17 %, and 82 % and more where such
      // steps were accepted.
      EXPECT_LT(session.balance().max_relative_energy_drift(), 0.25) << ratio << ' ' << cells;
      // A user who has taken "auto" is not told to take a smaller step, but to give one.
      EXPECT_FALSE(any_warning(session, "Take a smaller time.step"));
      EXPECT_EQ(any_warning(session, "Give time.step in seconds"),
                session.balance().max_relative_energy_drift() > 0.1);
    }
  }
}

// A moving body that mass damping a or drag slows down: its way is v₀/a (1 − e^(−at)). The stability limit
// allows steps with ah = 1.5, in which the energy error is round-off and the way is wrong.
TEST(AutomaticStepping, ResolvesTheDampingOfTheWholeBody) {
  constexpr double kRate = 1000.0;  // 1/s
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    for (const bool drag : {false, true}) {
      Scene scene =
          scene_of({GeneratorKind::kTetrahedron, {1, 1, 1}, {1, 1, 1}}, elastic(1e5, 0.3));
      scene.initial.velocity = {1.0, 0.0, 0.0};
      scene.time = {rule, 0.0, true, 0.05};
      // All vertices of a tetrahedron have the same mass, so that drag acts as mass damping.
      if (drag) {
        scene.damping.drag = kRate * scene.material.density / 24.0;
      } else {
        scene.damping.mass_damping = kRate;
      }
      Session session(scene, mesh_of(scene));
      const Vector3 start = center_of_mass(session.system(), session.state().position);
      ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
      const double way = center_of_mass(session.system(), session.state().position).x() - start.x();
      const double exact = (1.0 - std::exp(-kRate * 0.05)) / kRate;
      EXPECT_NEAR(way, exact, (rule == Integrator::kVerlet ? 0.002 : 0.11) * exact) << drag;
      EXPECT_NEAR(session.steps().largest, 0.1 / kRate, 1e-6 / kRate);
    }
  }
}

// A penalty spring whose target begins to move under a body at rest: the first step has no constraint work
// yet, but the spring has energy. Steps far below the limit are no blow-up, and "auto" keeps its size.
TEST(AutomaticStepping, IsNotMisledByTheFirstStepOfAMovingSpring) {
  Scene scene = scene_of({GeneratorKind::kCube, {1, 1, 1}, {2, 2, 2}}, elastic(1e5, 0.4));
  scene.fix.resize(1);
  scene.fix[0].select = SelectPlane{1, 0.0, {}};
  scene.fix[0].is_penalty = true;
  scene.fix[0].penalty = 1e4;
  scene.fix[0].velocity = {0.0, 1.0, 0.0};
  scene.time = {Integrator::kVerlet, 2e-3, false, 0.5};
  Session fixed(scene, mesh_of(scene));
  EXPECT_EQ(fixed.run(), RunStatus::kFinished) << fixed.message();
  EXPECT_LT(fixed.balance().max_relative_energy_drift(), 0.01);
  scene.time.automatic = true;
  Session automatic(scene, mesh_of(scene));
  EXPECT_EQ(automatic.run(), RunStatus::kFinished) << automatic.message();
  EXPECT_LT(automatic.state().step, 150);  // 49 steps of half the limit
}

// The first step of a fall, with the rule of first order: half of the energy is missing whatever the size of
// the step. It does not become smaller.
TEST(AutomaticStepping, KeepsTheStepWhereASmallerOneDoesNotHelp) {
  Scene scene = scene_of({GeneratorKind::kTetrahedron, {1, 1, 1}, {1, 1, 1}}, elastic(1e6, 0.3));
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.time = {Integrator::kExplicit, 0.0, true, 1.0};
  Session session(scene, mesh_of(scene));
  const double first = session.time_step();
  ASSERT_TRUE(session.step()) << session.message();
  EXPECT_NEAR(session.balance().energy_error(), -0.5 * session.balance().energy_scale(),
              1e-6 * session.balance().energy_scale());
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(session.time_step(), first);
  EXPECT_EQ(session.steps().changes, 0);
}

// The kept state has its own step and schedule.
TEST(AutomaticStepping, GoesBackToTheStepOfTheGoodState) {
  Scene scene = press({2, 2, 2}, std::numeric_limits<double>::infinity());
  Session session(scene, mesh_of(scene));
  session.keep_good_states();
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(session.step());
  Scene other_scene = scene;
  Session other(other_scene, mesh_of(scene));
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(other.step());
  EXPECT_EQ(session.state().position, other.state().position);
  EXPECT_EQ(session.time_step(), other.time_step());
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kUnstable);
  session.go_back();
  EXPECT_EQ(session.status(), RunStatus::kRunning);
}

TEST(TheEnd, IsMetExactlyByAShorterStep) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
                                Integrator::kBackwardEuler}) {
    Scene scene = spinning_block(rule, 0.002, 0.0151);
    const TetMesh mesh = mesh_of(scene);
    Session session(scene, mesh);
    EXPECT_EQ(session.step_count(), 8);
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_EQ(session.state().step, 8);
    EXPECT_EQ(session.state().time, 0.0151);
    EXPECT_NEAR(session.steps().last, 0.0011, 1e-15);
    EXPECT_EQ(session.steps().smallest, 0.002);
    EXPECT_EQ(session.steps().changes, 0);
    // The same as with an event that makes the step shorter.
    Scene by_event = scene;
    TimeSettings rest = scene.time;
    rest.step = 0.0151 - 0.014;
    by_event.event.push_back({0.014, {SetTime{rest}}, "{}", "event.0"});
    Session other(by_event, mesh);
    ASSERT_EQ(other.run(), RunStatus::kFinished);
    EXPECT_LT((session.state().position - other.state().position).norm(),
              1e-10 * session.state().position.norm());

    // An end before the first step's.
    scene.time.end = 0.0007;
    Session one(scene, mesh);
    ASSERT_EQ(one.run(), RunStatus::kFinished);
    EXPECT_EQ(one.state().step, 1);
    EXPECT_EQ(one.state().time, 0.0007);
    // Round-off makes no step of its own, and the end is met all the same.
    for (const double end : {0.006, 0.1, 0.3, 0.7}) {
      scene.time.end = end;
      Session session_to(scene, mesh);
      ASSERT_EQ(session_to.run(), RunStatus::kFinished);
      EXPECT_EQ(session_to.state().step, std::llround(end / 0.002));
      EXPECT_EQ(session_to.state().time, end);
      EXPECT_EQ(session_to.steps().last, 0.002);
    }
  }
}

TEST(TheEnd, IsWhereAllRunsOfAStudyEnd) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  const TetMesh mesh = mesh_of(scene);
  StudySettings settings;
  settings.integrators = {Integrator::kVerlet, Integrator::kMidpoint};
  settings.steps = {0.0003, 0.0007};
  settings.reference_step = 0.00011;
  class AtTheEnd : public Observer {
   public:
    void on_finish(const Session& session) override { EXPECT_EQ(session.state().time, 0.01); }
  };
  const ObserverFactory watch = [](const std::string&) {
    std::vector<std::unique_ptr<Observer>> observers;
    observers.push_back(std::make_unique<AtTheEnd>());
    return observers;
  };
  const StudyResult result = run_study(scene, mesh, settings, watch);
  EXPECT_TRUE(result.remarks.empty());
  std::vector<StudyRow> rows = result.rows;  // without the reference
  std::erase_if(rows, [](const StudyRow& row) { return row.role != StudyRole::kRun; });
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].step, 0.0003);
  EXPECT_EQ(rows[0].steps, 34);
  EXPECT_EQ(rows[1].steps, 15);
  EXPECT_NEAR(rows[1].observed_order, 1.87, 0.05);  // as with steps of 0.01/32 and 0.01/16 s
  EXPECT_NEAR(rows[3].observed_order, 2.0, 0.02);
}

TEST(InvertedElements, AreCountedAndTheFirstIsNamed) {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {8, 2, 2}}, elastic(1e6, 0.3, "stvk"));
  scene.damping.viscosity = 200.0;
  scene.time = {Integrator::kBackwardEuler, 0.01, false, 1.0};
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  scene.constraint.push_back(driven(SelectPlane{0, 4.0, {}}, {}, Vector3(12.566, 0.0, 0.0)));
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  EXPECT_TRUE(session.may_invert());
  Index most = 0;
  std::int64_t first = -1;
  double first_time = 0.0;
  while (session.step()) {
    Index count = 0;
    for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
      const auto nodes = session.system().rest().gather(session.state().position, e);
      if (Matrix3(nodes.rightCols<3>().colwise() - nodes.col(0)).determinant() >= 0.0) continue;
      if (first < 0) {
        first = mesh.tetrahedron_id(e);
        first_time = session.state().time;
      }
      ++count;
    }
    most = std::max(most, count);
    ASSERT_EQ(session.inverted_elements().now, count) << session.state().step;
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  ASSERT_GT(most, 5);
  EXPECT_EQ(session.inverted_elements().most, most);
  EXPECT_EQ(session.inverted_elements().first, first);
  EXPECT_EQ(session.inverted_elements().first_time, first_time);
  EXPECT_TRUE(any_warning(session, "turned inside out"));
}

TEST(Warnings, TellOfAnEnergyErrorAndWhatTheStepResolves) {
  Scene scene = spinning_block(Integrator::kBackwardEuler, 0.05, 2.0);
  Session damped(scene, mesh_of(scene));
  EXPECT_FALSE(any_warning(damped, "energy error"));
  ASSERT_EQ(damped.run(), RunStatus::kFinished);
  ASSERT_GT(damped.balance().max_relative_energy_drift(), 0.2);
  EXPECT_TRUE(any_warning(damped, "energy error"));
  EXPECT_TRUE(any_warning(damped, "0.05 Hz"));  // 1/(400 × 0.05 s)
  scene.time.integrator = Integrator::kMidpoint;
  scene.time.step = 1e-3;
  Session resolved(scene, mesh_of(scene));
  ASSERT_EQ(resolved.run(), RunStatus::kFinished);
  EXPECT_FALSE(any_warning(resolved, "energy error"));
  EXPECT_EQ(resolved_frequency(Integrator::kVerlet, 1e-3), 50.0);
}

TEST(Warnings, TellOfLocking) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  for (const auto& [ratio, locks] : {std::pair{0.44, false}, {0.45, true}, {0.499, true}}) {
    scene.material.poissons_ratio = ratio;
    EXPECT_EQ(any_warning(Session(scene, mesh_of(scene)), "lock"), locks) << ratio;
  }
  scene.material.poissons_ratio = 0.3;
  Session session(scene, mesh_of(scene));
  MaterialSettings rubber = scene.material;
  rubber.poissons_ratio = 0.49;
  session.apply(SetMaterial{0, rubber});
  EXPECT_NE(session.edits().back().warning.find("lock"), std::string::npos);
}

}  // namespace
}  // namespace tetraction
