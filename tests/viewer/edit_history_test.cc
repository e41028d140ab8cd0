// Undo and redo of every kind of edit, and the replay of all of it.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "support/obstacles.h"
#include "support/rules.h"
#include "support/temporary_folder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

// A body with one of everything.
Scene rich_scene(Integrator integrator) {
  Scene scene = spinning_block(integrator, 1e-3, 0.1);
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  scene.force = {load(SelectNearest{{2, 1, 1}}, {30, 0, 10})};
  scene.constraint = {rod(2, 11)};
  scene.obstacle = {plane_obstacle("floor", {0.0, -1.0, 0.0})};
  return scene;
}

struct NamedEdit {
  const char* name;
  Edit edit;
};

std::vector<NamedEdit> every_kind(const Scene& scene) {
  MaterialSettings rubber;
  rubber.model = "mooney-rivlin";
  rubber.youngs_modulus = 6e4;
  rubber.poissons_ratio = 0.35;
  rubber.numbers["ratio"] = 0.3;
  TimeSettings time = scene.time;
  time.integrator =
      is_implicit(scene.time.integrator) ? Integrator::kVerlet : Integrator::kMidpoint;
  time.step = 0.7e-3;
  TimeSettings automatic;
  automatic.integrator = Integrator::kVerlet;
  automatic.automatic = true;
  SolverSettings solver;
  solver.linear = LinearSolver::kCg;
  solver.tolerance = 1e-9;
  ForceSettings changed = scene.force[0];
  changed.vector = {-20, 5, 0};
  changed.until = 0.5;
  ForceSettings added = load(SelectBox{{1, 0, 0}, {2, 1, 0}}, {0, 4, 4});
  FixSettings moved = scene.fix[0];
  moved.offset = Vector3(0.01, 0.0, 0.02);
  FixSettings dragged = moving(SelectNearest{{2, 0, 1}}, {0.0, 0.1, 0.0});
  dragged.offset = Vector3(0.02, 0.01, 0.0);
  FixSettings spring = springs(SelectVertices{{2}}, 400.0);
  ConstraintSettings longer = scene.constraint[0];
  longer.length = 1.43;
  ConstraintSettings plane = on_plane(SelectNearest{{2, 0, 0}}, {1, 1, 1});
  ObstacleSettings moving_floor = scene.obstacle.at(0);
  moving_floor.point.y() = -0.9;
  moving_floor.velocity = {0.0, 0.1, 0.0};
  const ObstacleSettings lid = plane_obstacle("lid", {0.0, 3.0, 0.0}, {0.0, -1.0, 0.0});
  const MomentumSettings kick{SelectPlane{0, 2.0, {}}, {0, 3, 1}, {}};
  const ShiftSettings shift{
      {8, 5}, {{0.02, 0.0, 0.01}, {0.0, 0.01, 0.0}}, {{1, 2, 3}, {0, 0, -5}}, {}};
  return {
      {"material", SetMaterial{0, rubber}},
      {"time", SetTime{time}},
      {"automatic step", SetTime{automatic}},
      {"solver", SetSolver{solver}},
      {"damping", SetDamping{{2.0, 0.5, 30.0}}},
      {"pull", SetPull{{{2, 5}, {2.0, 0.5, 0.5}, 40.0, 1.0}}},
      {"environment", SetEnvironment{{EnvironmentKind::kAttraction, 20.0, Vector3(1, 2, 3), 0.5}}},
      {"change a force", SetForce{0, changed}},
      {"add a force", SetForce{std::nullopt, added}},
      {"move a fix", SetFix{0, moved}},
      {"add a fix", SetFix{std::nullopt, dragged}},
      {"add a spring", SetFix{std::nullopt, spring}},
      {"release some", Unfix{SelectBox{{0, 0, 0}, {0, 1, 0}}, {}}},
      {"change a constraint", SetConstraint{0, longer}},
      {"add a constraint", SetConstraint{std::nullopt, plane}},
      {"remove a constraint", RemoveConstraint{0}},
      {"change an obstacle", SetObstacle{0, moving_floor}},
      {"add an obstacle", SetObstacle{std::nullopt, lid}},
      {"remove an obstacle", RemoveObstacle{0}},
      {"momentum", SetMomentum{kick}},
      {"shift", ShiftState{shift}},
      {"release all", Unfix{}}};
}

// The settings and whom they hold, as text to compare.
std::string text_of(const Simulation& simulation) {
  Scene scene = simulation.scene();
  const Settings settings = simulation.settings();
  scene.material = settings.materials[0];
  scene.time = settings.time;
  scene.time.end = 1.0;
  scene.solver = settings.solver;
  scene.damping = settings.damping;
  scene.environment = settings.environment;
  scene.pull = settings.pull;
  scene.force.clear();
  for (const ForceSettings& force : settings.loads.force) {
    if (!force.vector.isZero(0.0)) scene.force.push_back(force);
  }
  scene.fix.clear();
  scene.obstacle.clear();
  for (const BodyObstacle& obstacle : settings.obstacles) {
    if (!obstacle.removed) scene.obstacle.push_back(obstacle.settings);
  }
  std::string text = scene_text(scene, "");
  for (const std::uint8_t fixed : simulation.snapshot()->fixed) text += fixed != 0 ? '1' : '0';
  return text;
}

// Backward Euler's momenta need not keep the rod's length as they are projected by an edit.
double momentum_round_off(Integrator integrator) {
  return integrator == Integrator::kBackwardEuler ? 1e-3 : 1e-10;
}

class UndoneEdits : public testing::TestWithParam<Integrator> {};

INSTANTIATE_TEST_SUITE_P(Rules, UndoneEdits,
                         testing::Values(Integrator::kVerlet, Integrator::kMidpoint,
                                         Integrator::kBackwardEuler),
                         name_of_rule);

TEST_P(UndoneEdits, AtOnceEverythingIsAsItWas) {
  const Scene scene = rich_scene(GetParam());
  for (const NamedEdit& named : every_kind(scene)) {
    SCOPED_TRACE(named.name);
    const auto simulation = simulation_of(scene);
    make_steps(*simulation, 7);
    const auto before = simulation->snapshot();
    const std::string text = text_of(*simulation);
    simulation->edit(named.edit, named.name);
    settle(*simulation);
    expect_no_notices(*simulation);
    EXPECT_EQ(simulation->undo_text(), named.name);
    EXPECT_EQ(simulation->redo_text(), "");
    const auto edited = simulation->snapshot();
    const std::string edited_text = text_of(*simulation);
    undo(*simulation);
    expect_no_notices(*simulation);
    EXPECT_EQ(simulation->undo_text(), "");
    EXPECT_EQ(simulation->redo_text(), named.name);
    EXPECT_EQ(text_of(*simulation), text);
    const auto undone = simulation->snapshot();
    EXPECT_LT((undone->position - before->position).norm(), 1e-12);
    EXPECT_LT((undone->momentum - before->momentum).norm(),
              momentum_round_off(GetParam()) * before->momentum.norm());
    redo(*simulation);
    expect_no_notices(*simulation);
    EXPECT_EQ(text_of(*simulation), edited_text);
    EXPECT_LT((simulation->snapshot()->position - edited->position).norm(), 1e-12);
    EXPECT_LT((simulation->snapshot()->momentum - edited->momentum).norm(),
              momentum_round_off(GetParam()) * before->momentum.norm());
    simulation->undo();
    make_steps(*simulation, 3);
    expect_no_notices(*simulation);
    EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
    expect_bitwise_equal(history_of_run(simulation->recorded_scene(), simulation->mesh()),
                         simulation->history(0));
  }
}

TEST_P(UndoneEdits, LaterTheSettingsAreAsTheyWere) {
  const Scene scene = rich_scene(GetParam());
  for (const NamedEdit& named : every_kind(scene)) {
    SCOPED_TRACE(named.name);
    const auto simulation = simulation_of(scene);
    make_steps(*simulation, 4);
    const std::string text = text_of(*simulation);
    simulation->edit(named.edit, named.name);
    make_steps(*simulation, 4);
    simulation->undo();
    make_steps(*simulation, 4);
    expect_no_notices(*simulation);
    EXPECT_EQ(text_of(*simulation), text);
    EXPECT_EQ(simulation->snapshot()->step, 12);
    EXPECT_EQ(simulation->snapshot()->status, RunStatus::kRunning);
  }
}

TEST_P(UndoneEdits, SessionsReplayBitwiseFromTheirSavedScene) {
  const Scene scene = rich_scene(GetParam());
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 3);
  int number = 0;
  for (const NamedEdit& named : every_kind(scene)) {
    simulation->edit(named.edit, named.name);
    make_steps(*simulation, 2);
    if (++number % 3 == 0) {
      simulation->undo();
      make_steps(*simulation, 1);
      simulation->redo();
    }
    if (number % 4 == 0) {
      simulation->undo();
      simulation->undo();
      simulation->redo();
    }
    make_steps(*simulation, 1);
  }
  for (const Notice& notice : simulation->take_notices()) {
    EXPECT_EQ(notice.kind, Notice::Kind::kWarning) << notice.text;
  }
  ASSERT_EQ(simulation->snapshot()->status, RunStatus::kRunning) << simulation->snapshot()->message;
  const std::vector<HistoryRow> rows = simulation->history(0);
  const Scene recorded = simulation->recorded_scene();
  expect_bitwise_equal(history_of_run(recorded, simulation->mesh()), rows);

  const testing_support::TemporaryFolder temporary;
  const std::string path = (temporary.path() / "replay.toml").string();
  write_scene(recorded, path);
  const Scene read = read_scene(path);
  expect_bitwise_equal(history_of_run(read, simulation->mesh()), rows);
}

TEST(EditHistory, ADragIsUndoneInOne) {
  const Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  const auto before = simulation->snapshot();
  FixSettings held = fix(SelectVertices{{4}});
  const Vector3 start = before->position.segment<3>(3 * 4);
  held.target = start;
  simulation->edit(SetFix{std::nullopt, held}, "drag vertex 4");
  for (int i = 1; i <= 10; ++i) {
    held.target = start + Vector3(0.005 * i, 0.0, 0.0);
    simulation->edit(SetFix{kNewest, held}, "drag vertex 4", true);
  }
  settle(*simulation);
  EXPECT_EQ(Vector3(simulation->snapshot()->position.segment<3>(12)), *held.target);
  EXPECT_EQ(simulation->snapshot()->fixed[4], 1);
  simulation->edit(Unfix{SelectAll{}, {}, kNewest}, "drag vertex 4", true);
  settle(*simulation);
  EXPECT_EQ(simulation->snapshot()->fixed[4], 0);
  undo(*simulation);
  EXPECT_LT((simulation->snapshot()->position - before->position).norm(), 1e-14);
  EXPECT_EQ(simulation->undo_text(), "");
  simulation->redo();
  make_steps(*simulation, 5);
  simulation->undo();  // it is held nowhere, before and after: nothing but that
  make_steps(*simulation, 5);
  expect_no_notices(*simulation);
  EXPECT_EQ(simulation->snapshot()->fixed[4], 0);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), simulation->mesh()),
                       simulation->history(0));
}

TEST(EditHistory, TheOppositeImpulseIsGivenLater) {
  const Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 5);
  const Vector3 before = simulation->history(0).back().linear_momentum;
  simulation->edit(SetMomentum{{SelectPlane{0, 2.0, {}}, {0, 30, 0}, {}}}, "kick");
  make_steps(*simulation, 5);
  EXPECT_GT((simulation->history(0).back().linear_momentum - before).norm(), 1.0);
  simulation->undo();
  make_steps(*simulation, 5);
  EXPECT_LT((simulation->history(0).back().linear_momentum - before).norm(), 1e-9);
}

TEST(EditHistory, ANewEditEndsWhatCouldBeRedone) {
  const auto simulation = simulation_of(spinning_block(Integrator::kVerlet, 1e-3, 0.1));
  simulation->edit(SetDamping{{.drag = 1.0}}, "one");
  simulation->edit(SetDamping{{.drag = 2.0}}, "two");
  undo(*simulation);
  EXPECT_EQ(simulation->settings().damping.drag, 1.0);
  EXPECT_EQ(simulation->undo_text(), "one");
  EXPECT_EQ(simulation->redo_text(), "two");
  simulation->edit(SetDamping{{.drag = 3.0}}, "three");
  settle(*simulation);
  EXPECT_EQ(simulation->redo_text(), "");
  simulation->redo();
  for (int i = 0; i < 5; ++i) simulation->undo();
  settle(*simulation);
  EXPECT_EQ(simulation->settings().damping.drag, 0.0);
  expect_no_notices(*simulation);
}

TEST(Recording, KeepsTheEventsOfTheSceneWithTheirNumbers) {
  Scene scene = rich_scene(Integrator::kVerlet);
  ForceSettings mine = scene.force[0];
  mine.vector = {0, 0, 50};
  EventSettings adds;
  adds.at = 0.0045;  // between two steps
  adds.edits = {SetForce{std::nullopt, mine}};
  adds.echo = "{}";
  mine.vector = {0, 0, -50};
  EventSettings changes = adds;
  changes.at = 0.01;
  TimeSettings coarser = scene.time;
  coarser.step = 2e-3;
  changes.edits = {SetForce{1, mine}, SetTime{coarser}};
  EventSettings later = adds;
  later.at = 0.08;
  later.edits = {SetForce{1, scene.force[0]}};
  scene.event = {adds, changes, later};
  const auto simulation = simulation_of(scene);
  make_steps(*simulation, 2);
  ForceSettings by_hand = scene.force[0];
  by_hand.vector = {1, 0, 0};
  simulation->edit(SetForce{std::nullopt, by_hand}, "by hand");
  make_steps(*simulation, 3);
  simulation->edit(SetDamping{{.drag = 4.0}}, "at the time of an event");
  make_steps(*simulation, 15);
  expect_no_notices(*simulation);
  const Settings settings = simulation->settings();
  ASSERT_EQ(settings.loads.force.size(), 3U);
  EXPECT_EQ(settings.loads.force[1].vector, Vector3(1, 0, 0)) << "not what the event means";
  EXPECT_EQ(settings.loads.force[2].vector, Vector3(0, 0, -50));
  EXPECT_EQ(settings.time.step, 2e-3);
  const Scene recorded = simulation->recorded_scene();
  EXPECT_EQ(recorded.time.end > 0.0, true);
  EXPECT_EQ(std::get<SetForce>(recorded.event.back().edits.at(0)).index, 2U);
  expect_bitwise_equal(history_of_run(recorded, simulation->mesh()), simulation->history(0));
}

TEST(Recording, BeforeTheFirstStepTheEndIsTheScenes) {
  const Scene scene = rich_scene(Integrator::kVerlet);
  const auto simulation = simulation_of(scene);
  TimeSettings time = scene.time;
  time.step = 2e-3;
  simulation->edit(SetTime{time}, "step");
  settle(*simulation);
  const Scene recorded = simulation->recorded_scene();
  EXPECT_EQ(recorded.time.end, scene.time.end);
  EXPECT_EQ(std::get<SetTime>(recorded.event.at(0).edits.at(0)).settings.end, scene.time.end);
  EXPECT_EQ(history_of_run(recorded, simulation->mesh()).size(), 51U);
}

// Whatever a person does: nothing crashes, states stay finite, and all of it can be replayed.
TEST(Simulation, SurvivesRandomEdits) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto below = [&random](int n) {
      return std::uniform_int_distribution<int>(0, n - 1)(random);
    };
    const Scene scene = rich_scene(Integrator::kVerlet);
    const std::vector<NamedEdit> edits = every_kind(scene);
    const auto simulation = simulation_of(scene);
    std::uniform_real_distribution<double> factor(0.3, 3.0);
    for (int i = 0; i < 600; ++i) {
      switch (below(12)) {
        case 0:
          simulation->run();
          break;
        case 1:
          simulation->pause();
          break;
        case 2:
          simulation->step();
          break;
        case 3:
          simulation->undo();
          break;
        case 4:
          simulation->redo();
          break;
        case 5:
          if (below(20) == 0) simulation->reset();
          break;
        case 6: {
          const int color = below(7);
          simulation->set_color_field(
              color > 0 ? color_quantities()[static_cast<std::size_t>(color - 1)] : nullptr);
          break;
        }
        case 7: {
          TimeSettings time = simulation->settings().time;
          time.automatic = false;
          time.step = 2e-3 * factor(random);
          time.integrator = static_cast<Integrator>(below(4));
          simulation->edit(SetTime{time}, "time");
          break;
        }
        case 8:
          if (simulation->snapshot()->status != RunStatus::kRunning) simulation->go_back();
          break;
        default: {
          const NamedEdit& named =
              edits[static_cast<std::size_t>(below(static_cast<int>(edits.size())))];
          simulation->edit(named.edit, named.name, below(3) == 0);
        }
      }
      if (below(4) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
      const auto snapshot = simulation->snapshot();
      ASSERT_EQ(snapshot->position.size(), 3 * simulation->mesh().vertex_count());
      ASSERT_TRUE(snapshot->position.allFinite());
    }
    simulation->pause();
    go_back(*simulation);
    for (const Notice& notice : simulation->take_notices()) EXPECT_FALSE(notice.text.empty());
    if (simulation->snapshot()->step == 0) continue;
    expect_bitwise_equal(history_of_run(simulation->recorded_scene(), simulation->mesh()),
                         simulation->history(0));
  }
}

// An event of a scene file names the keys that it changes. The others belong to the user.
TEST(Recording, EventsKeepSettingsThatTheyDoNotName) {
  const std::string path =
      (std::filesystem::path(testing::TempDir()) / "event_names_keys.toml").string();
  {
    std::ofstream file(path);
    file << R"([mesh]
generate = { kind = "box", size = [1, 0.3, 0.3], cells = [3, 1, 1] }
[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
[time]
integrator = "midpoint"
step = 0.01
end = 0.2
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[event]]
at = 0.03
set = { "time.step" = 5e-3, "material.youngs_modulus" = 2e6, "environment.strength" = 1.5 }
[[event]]
at = 0.06
set = { "solver.tolerance" = 1e-9, "time.integrator" = "midpoint" }
)";
  }
  const Scene scene = read_scene(path);
  const auto simulation = simulation_of(scene);
  TimeSettings time = scene.time;
  time.integrator = Integrator::kBackwardEuler;
  MaterialSettings material = scene.material;
  material.model = "stvk";
  material.poissons_ratio = 0.3;
  EnvironmentSettings sideways = scene.environment;
  sideways.direction = Vector3::UnitX();
  simulation->edit(SetTime{time}, "integrator");
  simulation->edit(SetMaterial{0, material}, "material");
  simulation->edit(SetEnvironment{sideways}, "direction");
  make_steps(*simulation, 1);
  {  // The events that are still to come keep the settings in the recorded scene, too.
    const Scene recorded = simulation->recorded_scene();
    ASSERT_EQ(recorded.event.size(), 5U);
    const std::vector<Edit>& first = recorded.event[3].edits;
    ASSERT_EQ(first.size(), 3U);
    EXPECT_EQ(std::get<SetMaterial>(first[1]).material.model, "stvk");
    EXPECT_EQ(std::get<SetMaterial>(first[1]).material.youngs_modulus, 2e6);
    EXPECT_EQ(std::get<SetTime>(first[2]).settings.integrator, Integrator::kBackwardEuler);
    EXPECT_EQ(std::get<SetTime>(recorded.event[4].edits.at(1)).settings.step, 5e-3);
  }
  make_steps(*simulation, 4);
  Settings settings = simulation->settings();
  EXPECT_EQ(settings.time.integrator, Integrator::kBackwardEuler);
  EXPECT_EQ(settings.time.step, 5e-3);
  EXPECT_EQ(settings.materials[0].model, "stvk");
  EXPECT_EQ(settings.materials[0].poissons_ratio, 0.3);
  EXPECT_EQ(settings.materials[0].youngs_modulus, 2e6);
  EXPECT_EQ(settings.environment.direction, Vector3::UnitX());
  EXPECT_EQ(settings.environment.strength, 1.5);
  make_steps(*simulation, 6);
  settings = simulation->settings();
  EXPECT_EQ(settings.time.integrator, Integrator::kMidpoint) << "a key that the event names";
  EXPECT_EQ(settings.time.step, 5e-3);
  EXPECT_EQ(settings.solver.tolerance, 1e-9);
  expect_no_notices(*simulation);
  expect_bitwise_equal(history_of_run(simulation->recorded_scene(), simulation->mesh()),
                       simulation->history(0));
}

// Named parameters that do not go with those of the user: the event is made as it is written.
TEST(Recording, AnEventForAnotherModelBringsItsWholeMaterial) {
  Scene scene = rich_scene(Integrator::kVerlet);
  MaterialSettings stiffer;
  stiffer.numbers["mu"] = 5e5;
  stiffer.numbers["lambda"] = 4e5;
  EventSettings event;
  event.at = 0.002;
  event.edits = {SetMaterial{0, stiffer}};
  event.echo = "{}";
  event.changed_keys = {"material.mu"};
  scene.event = {event};
  scene.material = stiffer;
  scene.material.numbers["mu"] = 1e5;
  const auto simulation = simulation_of(scene);
  MaterialSettings by_hand;
  by_hand.youngs_modulus = 3e5;
  by_hand.poissons_ratio = 0.3;
  simulation->edit(SetMaterial{0, by_hand}, "by hand");
  make_steps(*simulation, 5);
  expect_no_notices(*simulation);
  const MaterialSettings now = simulation->settings().materials[0];
  EXPECT_EQ(number_of(now, "mu"), 5e5);
  EXPECT_EQ(number_of(now, "lambda"), 4e5);
  EXPECT_FALSE(now.youngs_modulus.has_value());
}

}  // namespace
}  // namespace tetraction::viewer
