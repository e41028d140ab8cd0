
#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "tetraction/dynamics/nodal_fields.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;
using Clock = std::chrono::steady_clock;

Scene small_scene(Integrator integrator = Integrator::kVerlet, double step = 1e-3) {
  return spinning_block(integrator, step, 0.1);
}

// Polls until it holds, for a minute at most.
template <class Condition>
bool eventually(const Condition& holds) {
  const auto end = Clock::now() + std::chrono::seconds(60);
  while (!holds()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

TEST(Simulation, IsPausedAtTheStart) {
  const auto simulation = simulation_of(small_scene());
  settle(*simulation);
  const auto snapshot = simulation->snapshot();
  ASSERT_NE(snapshot, nullptr);
  EXPECT_EQ(snapshot->step, 0);
  EXPECT_FALSE(snapshot->running);
  EXPECT_EQ(snapshot->status, RunStatus::kRunning);
  EXPECT_EQ(snapshot->position.size(), 3 * simulation->mesh().vertex_count());
  EXPECT_GT(snapshot->stable_step, 0.0);
  EXPECT_EQ(simulation->history(0).size(), 1U);
  EXPECT_EQ(simulation->undo_text(), "");
  expect_no_notices(*simulation);
}

TEST(Simulation, MakesTheStepsOfASession) {
  const Scene scene = small_scene();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 20);
  Session session(scene, mesh_of(scene));
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(session.step());
  const auto snapshot = simulation->snapshot();
  EXPECT_EQ(snapshot->step, 20);
  EXPECT_EQ(snapshot->time, session.state().time);
  EXPECT_EQ(snapshot->position, session.state().position);
  EXPECT_EQ(snapshot->momentum, session.state().momentum);
  EXPECT_EQ(snapshot->velocity, session.state().velocity);
  expect_no_notices(*simulation);
}

TEST(Simulation, RunsPastTheEndOfTheSceneUntilItIsPaused) {
  Scene scene = small_scene();
  scene.time.end = 0.01;
  const auto simulation = simulation_of(scene);
  simulation->run();
  ASSERT_TRUE(eventually([&] { return simulation->snapshot()->step > 50; }));
  EXPECT_TRUE(simulation->snapshot()->running);
  EXPECT_FALSE(simulation->idle());
  simulation->pause();
  settle(*simulation);
  const auto paused = simulation->snapshot();
  EXPECT_FALSE(paused->running);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(simulation->snapshot()->step, paused->step);
  const std::vector<HistoryRow> rows = simulation->history(0);
  EXPECT_EQ(rows.back().step, paused->step);
  make_steps(*simulation, 1);
  EXPECT_EQ(simulation->snapshot()->step, paused->step + 1);
}

TEST(Simulation, AStepWhileRunningPauses) {
  const auto simulation = simulation_of(small_scene());
  simulation->run();
  make_steps(*simulation, 1);
  EXPECT_FALSE(simulation->snapshot()->running);
  EXPECT_GE(simulation->snapshot()->step, 1);
}

TEST(Simulation, ResetForgetsEditsAndHistory) {
  const Scene scene = small_scene();
  const auto simulation = simulation_of(scene);
  const auto start = simulation->snapshot();
  make_steps(*simulation, 5);
  simulation->edit(SetDamping{{.viscosity = 50.0}}, "viscosity 50 Pa s");
  make_steps(*simulation, 5);
  const std::size_t generation = simulation->history_generation();
  EXPECT_EQ(simulation->marks().size(), 1U);
  simulation->run();
  simulation->reset();
  settle(*simulation);
  const auto snapshot = simulation->snapshot();
  EXPECT_EQ(snapshot->step, 0);
  EXPECT_FALSE(snapshot->running);
  EXPECT_EQ(snapshot->position, start->position);
  EXPECT_GT(snapshot->body, start->body);
  EXPECT_EQ(simulation->settings().damping.viscosity, 0.0);
  EXPECT_GT(simulation->history_generation(), generation);
  EXPECT_EQ(simulation->history(0).size(), 1U);
  EXPECT_TRUE(simulation->marks().empty());
  EXPECT_EQ(simulation->undo_text(), "");
  EXPECT_TRUE(simulation->recorded_scene().event.empty());
}

TEST(Simulation, AnEditIsInForceAtTheNextStep) {
  const Scene scene = small_scene();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 10);
  const EnvironmentSettings gravity = testing_support::gravity(9.81);
  simulation->edit(SetEnvironment{gravity}, "gravity");
  make_steps(*simulation, 1);
  const std::vector<HistoryRow> rows = simulation->history(10);
  ASSERT_EQ(rows.size(), 2U);
  const double change = rows[1].linear_momentum.y() - rows[0].linear_momentum.y();
  EXPECT_NEAR(change, -9.81 * 2000.0 * 1e-3, 1e-6);  // 2 m³ of 1000 kg/m³
  EXPECT_EQ(simulation->settings().environment.kind, EnvironmentKind::kGravity);
  ASSERT_EQ(simulation->marks().size(), 1U);
  EXPECT_EQ(simulation->marks()[0].what, "gravity");
  EXPECT_EQ(simulation->marks()[0].time, rows[0].time);
}

TEST(Simulation, SettingsWhileRunningAreInForceInTime) {
  const auto simulation = simulation_of(small_scene());
  simulation->run();
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kBackwardEuler,
                                      Integrator::kExplicit, Integrator::kVerlet}) {
    TimeSettings time = simulation->settings().time;
    time.integrator = integrator;
    simulation->edit(SetTime{time}, to_string(integrator));
    ASSERT_TRUE(eventually([&] { return simulation->settings().time.integrator == integrator; }));
    const Index now = simulation->snapshot()->step;
    ASSERT_TRUE(eventually([&] { return simulation->snapshot()->step > now + 3; }));
  }
  simulation->pause();
  settle(*simulation);
  expect_no_notices(*simulation);
}

TEST(Simulation, ARefusedEditLeavesEverythingAsItWas) {
  const Scene scene = small_scene();
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  const auto before = simulation->snapshot();
  MaterialSettings wrong = scene.material;
  wrong.poissons_ratio = 0.7;
  MaterialSettings heavier = scene.material;
  heavier.density = 2000.0;
  FixSettings nothing = fix(SelectGroup{"nowhere"});
  EnvironmentSettings upward;
  upward.strength = -1.0;
  TimeSettings backward = scene.time;
  backward.step = -1e-3;
  SolverSettings sloppy;
  sloppy.tolerance = 2.0;
  ForceSettings over;
  over.until = -1.0;
  const std::vector<Edit> edits{SetMaterial{0, wrong},
                                SetMaterial{0, heavier},
                                SetMaterial{4, scene.material},
                                SetDamping{{.drag = -1.0}},
                                SetFix{std::nullopt, nothing},
                                SetFix{kNewest, nothing},
                                SetEnvironment{upward},
                                SetTime{backward},
                                SetSolver{sloppy},
                                SetForce{std::nullopt, over},
                                SetForce{7, {}},
                                Unfix{SelectGroup{"nowhere"}, {}},
                                RemoveConstraint{0},
                                ShiftState{{{0}, {{0, 90, 0}}, {}, {}}}};
  for (const Edit& edit : edits) simulation->edit(edit, "wrong");
  settle(*simulation);
  const std::vector<Notice> notices = simulation->take_notices();
  EXPECT_EQ(notices.size(), edits.size());
  for (const Notice& notice : notices) {
    EXPECT_EQ(notice.kind, Notice::Kind::kRefused);
    EXPECT_FALSE(notice.text.empty());
  }
  EXPECT_TRUE(simulation->take_notices().empty());
  EXPECT_TRUE(simulation->marks().empty());
  EXPECT_EQ(simulation->undo_text(), "");
  EXPECT_EQ(simulation->snapshot()->position, before->position);
  make_steps(*simulation, 5);
  const auto untouched = simulation_of(scene);
  make_steps(*untouched, 10);
  EXPECT_EQ(simulation->snapshot()->position, untouched->snapshot()->position);
}

TEST(Simulation, ABlowUpPausesAndOffersTheLastGoodState) {
  Scene scene = small_scene(Integrator::kExplicit);
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 40);
  TimeSettings coarse = scene.time;
  coarse.step = 20.0 * simulation->snapshot()->stable_step;
  simulation->edit(SetTime{coarse}, "too coarse");
  simulation->run();
  ASSERT_TRUE(eventually([&] { return simulation->snapshot()->status != RunStatus::kRunning; }));
  settle(*simulation);
  const auto failed = simulation->snapshot();
  EXPECT_EQ(failed->status, RunStatus::kUnstable);
  EXPECT_FALSE(failed->running);
  EXPECT_FALSE(failed->message.empty());
  EXPECT_TRUE(failed->position.allFinite());
  simulation->take_notices();  // of the step

  // Nothing but going back is possible.
  simulation->run();
  simulation->step();
  simulation->edit(SetTime{scene.time}, "fine");
  undo(*simulation);
  EXPECT_EQ(simulation->take_notices().size(), 4U);
  EXPECT_EQ(simulation->snapshot()->step, failed->step);

  const std::size_t generation = simulation->history_generation();
  go_back(*simulation);
  const auto good = simulation->snapshot();
  EXPECT_EQ(good->status, RunStatus::kRunning);
  EXPECT_TRUE(good->message.empty());
  EXPECT_GE(good->step, 40);
  EXPECT_EQ(simulation->history(0).back().step, good->step);
  EXPECT_EQ(simulation->history(0).back().time, good->time);
  if (good->step < failed->step) {
    EXPECT_GT(simulation->history_generation(), generation);
  }
  EXPECT_EQ(simulation->undo_text(), "too coarse");
  simulation->undo();
  make_steps(*simulation, 30);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
  EXPECT_EQ(simulation->settings().time.step, scene.time.step);
  expect_no_notices(*simulation);
  const std::vector<HistoryRow> rows = simulation->history(0);
  for (std::size_t i = 1; i < rows.size(); ++i) ASSERT_EQ(rows[i].step, rows[i - 1].step + 1);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), mesh_of(scene)), rows);
}

TEST(Simulation, GoesOnAfterAStepThatDidNotConverge) {
  Scene scene = small_scene(Integrator::kMidpoint, 1e-2);
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 10);
  SolverSettings hopeless;
  hopeless.max_iterations = 1;
  hopeless.tolerance = 1e-13;
  simulation->edit(SetSolver{hopeless}, "one iteration");
  make_steps(*simulation, 1);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kNotConverged);
  EXPECT_EQ(simulation->snapshot()->step, 10);
  simulation->go_back();
  simulation->edit(SetSolver{scene.solver}, "as before");
  TimeSettings finer = scene.time;
  finer.step = 5e-3;
  simulation->edit(SetTime{finer}, "finer");
  make_steps(*simulation, 10);
  EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
  EXPECT_EQ(simulation->snapshot()->step, 20);
  expect_no_notices(*simulation);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), mesh_of(scene)),
                       simulation->history(0));
}

TEST(Simulation, StopsAfterTheStepInProgress) {
  Scene scene = small_scene(Integrator::kMidpoint, 1e-2);
  scene.mesh.generate->cells = {24, 12, 12};
  scene.solver.linear = LinearSolver::kFactor;
  {
    const auto simulation = simulation_of(scene);
    simulation->step();
    simulation->step();
    // While the first is being made, whatever the window asks for is answered at once.
    const auto start = Clock::now();
    for (int i = 0; i < 100; ++i) {
      EXPECT_NE(simulation->snapshot(), nullptr);
      EXPECT_EQ(simulation->settings().materials.size(), 1U);
      simulation->history(0);
      simulation->recorded_scene();
    }
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 1.0);
  }
  const auto running = simulation_of(small_scene());
  running->run();
}

TEST(Simulation, TheHistoryIsCompleteUnderAFastReader) {
  const auto simulation = simulation_of(small_scene());
  simulation->set_steps_per_snapshot(3);
  simulation->run();
  std::vector<HistoryRow> rows;
  std::uint64_t generation = 0;
  Index step = 0;
  while (rows.size() < 3000) {
    const std::vector<HistoryRow> more = simulation->history(rows.size());
    rows.insert(rows.end(), more.begin(), more.end());
    const auto snapshot = simulation->snapshot();
    ASSERT_GE(snapshot->generation, generation);
    ASSERT_GE(snapshot->step, step);
    ASSERT_NEAR(snapshot->time, 1e-3 * static_cast<double>(snapshot->step), 1e-9);
    generation = snapshot->generation;
    step = snapshot->step;
  }
  simulation->pause();
  settle(*simulation);
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i].step, static_cast<Index>(i));
}

TEST(Simulation, KeepsToTheSpeedLimitAndReactsAtOnce) {
  const auto simulation = simulation_of(small_scene());
  simulation->set_speed_limit(0.01);  // a step each 0.1 s
  const auto start = Clock::now();
  simulation->run();
  ASSERT_TRUE(eventually([&] { return simulation->snapshot()->step >= 3; }));
  EXPECT_GT(std::chrono::duration<double>(Clock::now() - start).count(), 0.15);
  simulation->set_speed_limit(1e-6);  // a step each 1000 s
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  simulation->edit(SetDamping{{.drag = 1.0}}, "drag");
  ASSERT_TRUE(eventually([&] { return simulation->settings().damping.drag == 1.0; }));
  simulation->set_speed_limit(0.0);
  const Index now = simulation->snapshot()->step;
  ASSERT_TRUE(eventually([&] { return simulation->snapshot()->step > now + 100; }));
  simulation->set_speed_limit(1e-6);
  simulation->pause();
  settle(*simulation);
  EXPECT_FALSE(simulation->snapshot()->running);
}

TEST(Simulation, ColoursByWhatIsAskedFor) {
  Scene scene = small_scene();
  scene.material_region = {{SelectBox{{1, 0, 0}, {2, 1, 1}}, scene.material, {}}};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 3);
  const TetMesh& mesh = simulation->mesh();
  for (const auto& [field, on_cells] :
       std::vector<std::pair<ColorField, bool>>{{find_quantity("displacement"), false},
                                                {find_quantity("velocity"), false},
                                                {find_quantity("von_mises"), true},
                                                {find_quantity("energy_density"), true},
                                                {find_quantity("jacobian"), true},
                                                {find_quantity("region"), true}}) {
    simulation->set_color_field(field);
    settle(*simulation);
    const auto snapshot = simulation->snapshot();
    EXPECT_EQ(snapshot->field, field);
    EXPECT_EQ(snapshot->field_on_cells, on_cells);
    const Index size = on_cells ? mesh.tetrahedron_count() : mesh.vertex_count();
    ASSERT_EQ(static_cast<Index>(snapshot->field_values.size()), size);
    for (const float value : snapshot->field_values) EXPECT_TRUE(std::isfinite(value));
    EXPECT_GT(*std::max_element(snapshot->field_values.begin(), snapshot->field_values.end()), 0.f);
  }
  EXPECT_EQ(simulation->settings().region_names.size(), 2U);
  simulation->set_color_field(nullptr);
  settle(*simulation);
  EXPECT_TRUE(simulation->snapshot()->field_values.empty());
}

// Quadratic tetrahedra have the colours of their vertices, also in the middles of edges.
TEST(Simulation, ColoursOfQuadraticTetrahedraAreThoseOfTheirVertices) {
  Scene scene = small_scene();
  const TetMesh mesh = with_edge_vertices(generate_mesh(*scene.mesh.generate));
  Simulation simulation(scene, mesh);
  make_steps(simulation, 3);
  const Session session(scene, mesh);
  for (const ColorField field : {find_quantity("von_mises"), find_quantity("jacobian")}) {
    simulation.set_color_field(field);
    settle(simulation);
    const auto snapshot = simulation.snapshot();
    EXPECT_FALSE(snapshot->field_on_cells);
    const NodalFields fields = nodal_fields(session.system(), snapshot->position);
    const Matrix& expected =
        field == find_quantity("jacobian") ? fields.jacobian : fields.von_mises;
    ASSERT_EQ(static_cast<Index>(snapshot->field_values.size()), mesh.vertex_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      EXPECT_FLOAT_EQ(snapshot->field_values[static_cast<std::size_t>(v)],
                      static_cast<float>(expected(0, v)));
    }
  }
}

TEST(Simulation, ShowsForcesAndHeldVerticesOfTheNextStep) {
  const auto simulation = simulation_of(small_scene());
  ForceSettings force = load(SelectVertices{{3}}, {0, 7, 0});
  FixSettings fix = testing_support::fix(SelectVertices{{5}});
  simulation->edit(SetForce{std::nullopt, force}, "force");
  simulation->edit(SetFix{std::nullopt, fix}, "fix");
  settle(*simulation);
  const auto snapshot = simulation->snapshot();
  EXPECT_EQ(snapshot->step, 0);
  EXPECT_EQ(snapshot->external_force[3 * 3 + 1], 7.0);
  EXPECT_EQ(snapshot->fixed[5], 1);
  EXPECT_EQ(snapshot->fixed[3], 0);
  const Settings settings = simulation->settings();
  EXPECT_EQ(settings.loads.force.size(), 1U);
  EXPECT_EQ(settings.fixes.size(), 1U);
}

TEST(Simulation, TheStabilityLimitFollowsTheMaterial) {
  const Scene scene = small_scene();
  const auto simulation = simulation_of(scene);
  const double before = simulation->snapshot()->stable_step;
  MaterialSettings stiffer = scene.material;
  stiffer.youngs_modulus = 4.0 * *scene.material.youngs_modulus;
  simulation->edit(SetMaterial{0, stiffer}, "stiffer");
  settle(*simulation);
  EXPECT_NEAR(simulation->snapshot()->stable_step, 0.5 * before, 1e-2 * before);
}

TEST(Simulation, ASettingOfASliderThatWaitsGivesWayToTheNext) {
  Scene scene = small_scene(Integrator::kMidpoint, 1e-2);
  scene.mesh.generate->cells = {16, 8, 8};
  const auto simulation = simulation_of(scene);
  simulation->step();  // takes a while, in which the slider moves
  for (int i = 1; i <= 50; ++i) {
    simulation->edit(SetDamping{{.viscosity = static_cast<double>(i)}}, "viscosity", i > 1);
  }
  settle(*simulation);
  EXPECT_EQ(simulation->settings().damping.viscosity, 50.0);
  EXPECT_LE(simulation->marks().size(), 50U);
  undo(*simulation);
  EXPECT_EQ(simulation->settings().damping.viscosity, 0.0) << "all of it is one edit";
}

TEST(Simulation, AnEventThatDoesNotFitIsANoticeAndTheRunGoesOn) {
  Scene scene = small_scene();
  FixSettings far = fix(SelectVertices{{0}});
  far.target = Vector3(100, 0, 0);
  FixSettings slower = far;
  slower.velocity = {1, 0, 0};
  scene.event = {
      {0.005, {SetFix{std::nullopt, far}, SetFix{0, slower}, SetDamping{{.drag = 3.0}}}, "{}", {}}};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 10);
  EXPECT_EQ(simulation->take_notices().size(), 2U);
  EXPECT_EQ(simulation->snapshot()->step, 10);
  EXPECT_EQ(simulation->settings().damping.drag, 3.0);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), mesh_of(scene)),
                       simulation->history(0));
}

// An event that moves a handle brought it back after the user had switched it off.
TEST(Simulation, AnEventDoesNotBringBackAConstraintThatWasRemoved) {
  Scene scene = small_scene();
  scene.constraint = {rigid(SelectPlane{0, 0.0, {}})};
  ConstraintSettings moved = scene.constraint[0];
  moved.velocity = {0.0, 1.0, 0.0};
  EventSettings event;
  event.at = 0.005;
  event.edits = {SetConstraint{0, moved}};
  scene.event = {event};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 2);
  simulation->edit(RemoveConstraint{0}, "off");
  make_steps(*simulation, 8);
  const std::vector<Notice> notices = simulation->take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].text.find("switched off"), std::string::npos) << notices[0].text;
  EXPECT_EQ(simulation->history(0).back().constraint_work, 0.0);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), mesh_of(scene)),
                       simulation->history(0));
  // A scene whose own event removes it may have another one that makes it anew.
  EventSettings removal;
  removal.at = 0.003;
  removal.edits = {RemoveConstraint{0}};
  scene.event = {removal, event};
  const auto other = simulation_of(scene);
  make_steps(*other, 10);
  expect_no_notices(*other);
  EXPECT_NE(other->history(0).back().constraint_work, 0.0);
}

TEST(Simulation, AnEventDoesNotBringBackAFixedSetThatWasReleased) {
  Scene scene = small_scene();
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  FixSettings moved = scene.fix[0];
  moved.offset = Vector3(0.0, 0.01, 0.0);
  EventSettings event;
  event.at = 0.005;
  event.edits = {SetFix{0, moved}};
  scene.event = {event};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 2);
  simulation->edit(Unfix{SelectAll{}, {}, 0}, "off");
  settle(*simulation);
  // The saved scene has the same without the event.
  EXPECT_EQ(simulation->recorded_scene().event.size(), 1U);
  make_steps(*simulation, 8);
  const std::vector<Notice> notices = simulation->take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].text.find("a fixed set or a constraint that was deleted"), std::string::npos)
      << notices[0].text;
  EXPECT_TRUE(simulation->settings().present[list_of(FixSettings())].empty());
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), mesh_of(scene)),
                       simulation->history(0));
  EventSettings release;
  release.at = 0.003;
  release.edits = {Unfix{SelectAll{}, {}, 0}};
  scene.event = {release, event};
  const auto other = simulation_of(scene);
  make_steps(*other, 10);
  expect_no_notices(*other);
  EXPECT_EQ(other->settings().present[list_of(FixSettings())].size(), 1U);
}

TEST(Simulation, TheUndoOfARestartIsNoEdit) {
  const auto simulation = simulation_of(small_scene());
  simulation->edit(SetDamping{{.drag = 1.0}}, "drag");
  make_steps(*simulation, 3);
  const std::size_t saved = simulation->edit_count();
  restart(*simulation);
  EXPECT_FALSE(simulation->edited_since(saved));
  undo(*simulation);
  EXPECT_EQ(simulation->peek()->step, 3);
  EXPECT_FALSE(simulation->edited_since(saved));
  simulation->edit(SetDamping{{.drag = 2.0}}, "drag");
  settle(*simulation);
  EXPECT_TRUE(simulation->edited_since(saved));
}

TEST(Simulation, TellsWhetherThereAreEditsSinceACount) {
  const auto simulation = simulation_of(small_scene());
  settle(*simulation);
  EXPECT_FALSE(simulation->edited_since(0));
  simulation->edit(SetDamping{{.drag = 1.0}}, "drag");
  EXPECT_TRUE(simulation->edited_since(0)) << "also before it is made";
  settle(*simulation);
  EXPECT_TRUE(simulation->edited_since(0));
  const std::size_t saved = simulation->edit_count();
  EXPECT_FALSE(simulation->edited_since(saved));
  make_steps(*simulation, 3);
  EXPECT_FALSE(simulation->edited_since(saved)) << "steps are no edits";
  simulation->edit(SetDamping{{.drag = -1.0}}, "refused");
  settle(*simulation);
  EXPECT_FALSE(simulation->edited_since(saved)) << "nothing has changed";
  simulation->edit(SetDamping{{.drag = 2.0}}, "more");
  settle(*simulation);
  EXPECT_TRUE(simulation->edited_since(saved));
  simulation->undo();
  undo(*simulation);
  EXPECT_FALSE(simulation->edited_since(0)) << "all edits are undone";
  redo(*simulation);
  EXPECT_TRUE(simulation->edited_since(saved));
  const std::size_t saved_again = simulation->edit_count();
  restart(*simulation);
  EXPECT_FALSE(simulation->edited_since(saved_again)) << "the user has changed nothing";
  simulation->reset();
  settle(*simulation);
  EXPECT_FALSE(simulation->edited_since(0));
}

}  // namespace
}  // namespace tetraction::viewer
