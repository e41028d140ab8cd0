// Vertices that the mouse pulls with a spring.
#include <algorithm>
#include <cmath>

#include "support/temporary_folder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

// The cantilever of 486 tetrahedra whose energy an exact drag raised until the run failed.
Scene cantilever(Integrator integrator, double step) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.6, 0.1, 0.1}, {9, 3, 3}}, elastic(1e6, 0.4));
  scene.time = {integrator, step, false, 100.0};
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
  return scene;
}

class SpringDrags : public ::testing::Test {
 protected:
  void open(const Scene& scene) {
    simulation_ = simulation_of(scene);
    corner_ = simulation_->mesh().vertex_count() - 1;
    start_ = corner();
  }
  Vector3 corner() const { return vertex_block(simulation_->snapshot()->position, corner_); }
  const HistoryRow row() const { return simulation_->history(0).back(); }
  // As a hand moves: over some steps to the goal, then it waits there.
  void drag_by(const Vector3& way, int moves, int steps_between, int steps_after) {
    for (int i = 1; i <= moves; ++i) {
      simulation_->drag_to(start_ + static_cast<double>(i) / moves * way);
      make_steps(*simulation_, steps_between);
    }
    make_steps(*simulation_, steps_after);
  }

  std::unique_ptr<Simulation> simulation_;
  Index corner_ = 0;
  Vector3 start_;
};

TEST_F(SpringDrags, ALargeDragLeavesARunThatKeepsItsEnergy) {
  open(cantilever(Integrator::kEnergyMomentum, 5e-3));
  simulation_->pull({corner_});
  drag_by({0.0, 0.32, 0.0}, 40, 2, 60);
  EXPECT_GT(corner().y() - start_.y(), 0.2) << "the spring is strong enough to bend the body";
  release(*simulation_);
  const double released = row().total;
  make_steps(*simulation_, 300);
  EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning)
      << simulation_->snapshot()->message;
  EXPECT_NEAR(row().total, released, 1e-6 * released);
  EXPECT_LT(std::abs(row().energy_error), 1e-6 * released);
  // Its work is that of a user's force; nothing of the spring is left in the energies.
  EXPECT_GT(row().external_work, 0.0);
  EXPECT_EQ(row().edit_work, 0.0);
  EXPECT_EQ(row().constraint_work, 0.0);
  expect_no_notices(*simulation_);
}

TEST_F(SpringDrags, TheRecordedSceneReplaysBitwise) {
  for (const auto& [integrator, step] :
       {std::pair(Integrator::kMidpoint, 5e-3), std::pair(Integrator::kEnergyMomentum, 5e-3),
        std::pair(Integrator::kVerlet, 2e-4)}) {
    open(cantilever(integrator, step));
    make_steps(*simulation_, 3);
    simulation_->pull({corner_});
    drag_by({0.02, 0.05, 0.03}, 6, 3, 5);
    simulation_->set_pull_radius(1.25 * simulation_->snapshot()->pull_radius);
    make_steps(*simulation_, 5);
    release(*simulation_);
    make_steps(*simulation_, 10);
    const Scene recorded = simulation_->recorded_scene();
    EXPECT_GT(recorded.event.size(), 3U);
    expect_bitwise_equal(simulation_->history(0), history_of_run(recorded, simulation_->mesh()));
    const TemporaryFolder temporary;
    const std::string path = (temporary.path() / "recorded.toml").string();
    write_scene(recorded, path);
    expect_bitwise_equal(simulation_->history(0),
                         history_of_run(read_scene(path), simulation_->mesh()));
  }
}

// The stiffness is limited: the spring must not make a step unstable that was stable without it.
TEST_F(SpringDrags, LeaveTheStabilityLimitWhereItIs) {
  const Scene scene = cantilever(Integrator::kVerlet, 1e-5);
  Session session(scene, mesh_of(scene));
  const double before = session.current_limit().critical_step;
  open(scene);
  simulation_->pull({corner_});
  simulation_->drag_to(start_ + Vector3(0.0, 0.1, 0.0));
  settle(*simulation_);
  const Scene recorded = simulation_->recorded_scene();
  ASSERT_EQ(recorded.event.size(), 1U);
  session.apply(recorded.event[0].edits[0]);
  EXPECT_GT(session.settings().pull.stiffness, 0.0);
  EXPECT_GT(session.current_limit().critical_step, 0.95 * before);
  EXPECT_LE(session.current_limit().critical_step, before);
}

TEST_F(SpringDrags, AHandleThatIsLetGoInFlightHasTheSpeedOfTheMouse) {
  open(cantilever(Integrator::kEnergyMomentum, 1e-3));
  simulation_->pull({corner_});
  simulation_->drag_to(start_ + Vector3(0.0, 0.3, 0.0));
  settle(*simulation_);
  make_steps(*simulation_, 8);  // the body is on its way, and the mouse rests
  const auto flying = simulation_->snapshot();
  double before = 0.0;
  for (const Index v : flying->pulled) before += vertex_block(flying->momentum, v).y();
  ASSERT_GT(before, 0.0);
  release(*simulation_);
  const auto released = simulation_->snapshot();
  double after = 0.0;
  for (const Index v : flying->pulled) after += vertex_block(released->momentum, v).y();
  EXPECT_LT(std::abs(after), 1e-2 * before);
  EXPECT_TRUE(released->pulled.empty());
}

TEST_F(SpringDrags, UndoTakesTheSpringAwayAndDoesNotKickTheBody) {
  open(cantilever(Integrator::kEnergyMomentum, 2e-3));
  simulation_->pull({corner_});
  drag_by({0.0, 0.05, 0.0}, 5, 2, 3);
  EXPECT_EQ(simulation_->undo_text().substr(0, 12), "Drag vertex ");
  EXPECT_EQ(simulation_->marks().size(), 1U) << "all edits of a drag have one mark";
  release(*simulation_);
  make_steps(*simulation_, 5);
  const auto before = simulation_->snapshot();
  undo(*simulation_);
  EXPECT_EQ(simulation_->snapshot()->momentum, before->momentum);
  EXPECT_EQ(simulation_->snapshot()->position, before->position);
  EXPECT_TRUE(simulation_->undo_text().empty());
  expect_no_notices(*simulation_);
}

// While the simulation is paused, nothing moves, so that no drag can stop at an inverted element.
TEST_F(SpringDrags, MoveNothingWhilePaused) {
  open(cantilever(Integrator::kEnergyMomentum, 5e-3));
  simulation_->pull({corner_});
  simulation_->drag_to(start_ - Vector3(0.6, 0.0, 0.0));
  settle(*simulation_);
  EXPECT_EQ(corner(), start_);
  EXPECT_FALSE(simulation_->snapshot()->pulled.empty());
  release(*simulation_);
  make_steps(*simulation_, 5);
  EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning);
  expect_no_notices(*simulation_);
}

// The scene's own spring comes back after a drag.
TEST_F(SpringDrags, TheSpringOfTheSceneStays) {
  open(cantilever(Integrator::kEnergyMomentum, 5e-3));
  PullSettings own;
  own.vertices = {simulation_->mesh().vertex_id(corner_)};
  own.stiffness = 3.0;
  simulation_->edit(SetPull{own}, "Stiffness 3 N/m");
  simulation_->pull({corner_});
  simulation_->drag_to(Vector3(0.0, 0.5, 0.0));
  make_steps(*simulation_, 2);
  EXPECT_NE(simulation_->settings().pull.stiffness, 3.0);
  simulation_->release();
  settle(*simulation_);
  EXPECT_EQ(simulation_->settings().pull.stiffness, 3.0);
  EXPECT_EQ(simulation_->settings().pull.vertices, own.vertices);
  restart(*simulation_);
  EXPECT_EQ(simulation_->settings().pull.stiffness, 3.0);
}

}  // namespace
}  // namespace tetraction::viewer
