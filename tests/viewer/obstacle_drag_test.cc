// Obstacles that the mouse moves.
#include <algorithm>
#include <chrono>
#include <thread>

#include "support/obstacles.h"
#include "tetraction/dynamics/contact/contact.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

class ObstacleDrags : public ::testing::Test {
 protected:
  // A ball above a beam, which it touches if it comes down by more than 0.1 m.
  static Scene beam_and_ball(Integrator integrator, double step) {
    Scene scene = scene_of({GeneratorKind::kBox, {1.2, 0.3, 0.3}, {8, 2, 2}}, elastic(1.5e6, 0.4));
    scene.damping.viscosity = 50.0;
    scene.time = {integrator, step, false, 1.0};
    scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
    scene.obstacle = {sphere_obstacle("ball", {0.9, 1.4, 0.15}, 1.0)};
    return scene;
  }
  void open(const Scene& scene) {
    simulation_ = simulation_of(scene);
    first_point_ = drawn_point();
    center_ = scene.obstacle.at(0).center;
  }
  Vector3 drawn_point() const { return simulation_->snapshot()->obstacles->points.at(0); }
  // Of the center of the ball, where it is drawn.
  Vector3 place() const { return center_ + drawn_point() - first_point_; }
  double tip_height() const { return simulation_->snapshot()->position.tail<2>()[0]; }
  void run_until(const std::function<bool()>& is_done) {
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    simulation_->run();
    while (!is_done() && simulation_->snapshot()->status == RunStatus::kRunning &&
           std::chrono::steady_clock::now() < patience) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    simulation_->pause();
    settle(*simulation_);
  }
  void expect_nothing_refused() {
    for (const Notice& notice : simulation_->take_notices()) {
      EXPECT_NE(notice.kind, Notice::Kind::kRefused) << notice.text;
    }
  }

  std::unique_ptr<Simulation> simulation_;
  Vector3 first_point_, center_;
};

// The ball bends the beam and stops at the goal, and the recording has the same states bit by bit.
TEST_F(ObstacleDrags, PressTheBodyAndStopAtTheGoal) {
  for (const auto& [integrator, step] :
       {std::pair(Integrator::kEnergyMomentum, 2e-3), std::pair(Integrator::kBackwardEuler, 2e-3),
        std::pair(Integrator::kVerlet, 1e-4)}) {
    open(beam_and_ball(integrator, step));
    const Vector3 start = place();
    const double height = tip_height();
    simulation_->grab_obstacle(0, start);
    const Vector3 goal = start + Vector3(0.02, -0.15, 0.0);
    settle(*simulation_);
    simulation_->run();
    simulation_->drag_to(goal);
    run_until([&] { return (place() - goal).norm() < 1e-5; });
    make_steps(*simulation_, 3);
    EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning)
        << simulation_->snapshot()->message;
    EXPECT_LT((place() - goal).norm(), 1e-5) << to_string(integrator);
    EXPECT_LT(tip_height(), height - 0.01);
    release(*simulation_);
    expect_nothing_refused();
    make_steps(*simulation_, 3);
    EXPECT_LT((place() - goal).norm(), 1e-5);
    EXPECT_EQ(simulation_->undo_text(), "Drag obstacle \"ball\"");
    expect_bitwise_equal(history_of_run(simulation_->recorded_scene(), simulation_->mesh()),
                         simulation_->history(0));
  }
}

TEST_F(ObstacleDrags, MoveAtOnceWhilePausedButNotIntoTheBody) {
  open(beam_and_ball(Integrator::kMidpoint, 2e-3));
  const Vector3 start = place();
  simulation_->grab_obstacle(0, start);
  simulation_->drag_to(start + Vector3(0.0, -0.08, 0.0));
  settle(*simulation_);
  expect_nothing_refused();
  EXPECT_LT((place() - start - Vector3(0.0, -0.08, 0.0)).norm(), 1e-12);
  simulation_->drag_to(start + Vector3(0.0, -0.3, 0.0));
  settle(*simulation_);
  const std::vector<Notice> notices = simulation_->take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].text.find("penetrates the obstacle \"ball\""), std::string::npos)
      << notices[0].text;
  EXPECT_LT((place() - start - Vector3(0.0, -0.08, 0.0)).norm(), 1e-12);
  simulation_->drag_to(start + Vector3(0.1, -0.05, 0.0));
  release(*simulation_);
  EXPECT_LT((place() - start - Vector3(0.1, -0.05, 0.0)).norm(), 1e-12);
  EXPECT_EQ(simulation_->snapshot()->step, 0);
  undo(*simulation_);
  EXPECT_LT((place() - start).norm(), 1e-12);
  EXPECT_EQ(simulation_->undo_text(), "");
}

TEST_F(ObstacleDrags, LeaveTheObstacleItsOwnMotion) {
  Scene scene = beam_and_ball(Integrator::kMidpoint, 2e-3);
  scene.obstacle[0].velocity = {0.0, 0.25, 0.0};
  open(scene);
  make_steps(*simulation_, 10);
  const Vector3 start = place();
  EXPECT_NEAR(start.y(), 1.4 + 0.25 * 0.02, 1e-12);
  simulation_->grab_obstacle(0, start);
  make_steps(*simulation_, 10);
  EXPECT_LT((place() - start).norm(), 1e-12);
  release(*simulation_);
  make_steps(*simulation_, 10);
  EXPECT_LT((place() - start - Vector3(0.0, 0.005, 0.0)).norm(), 1e-12);
  simulation_->grab_obstacle(7, start);
  settle(*simulation_);
  const std::vector<Notice> notices = simulation_->take_notices();
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_NE(notices[0].text.find("not there"), std::string::npos) << notices[0].text;
}

}  // namespace
}  // namespace tetraction::viewer
