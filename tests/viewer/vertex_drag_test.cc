// Vertices that the mouse holds and leads.
#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;

class VertexDrags : public ::testing::Test {
 protected:
  static Scene beam_scene(Integrator integrator, double step) {
    Scene scene = scene_of({GeneratorKind::kBox, {1.2, 0.3, 0.3}, {8, 2, 2}}, elastic(1.5e6, 0.4));
    scene.damping.viscosity = 50.0;
    scene.time = {integrator, step, false, 1.0};
    scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
    return scene;
  }
  void open(const Scene& scene) {
    simulation_ = simulation_of(scene);
    tip_ = simulation_->mesh().vertex_count() - 1;
    start_ = tip();
  }
  Vector3 tip() const { return vertex_block(simulation_->snapshot()->position, tip_); }
  void expect_nothing_refused() {
    for (const Notice& notice : simulation_->take_notices()) {
      EXPECT_NE(notice.kind, Notice::Kind::kRefused) << notice.text;
    }
  }
  bool is_held() const {
    return simulation_->snapshot()->fixed[static_cast<std::size_t>(tip_)] != 0;
  }
  // Runs for so many steps and looks at none of the pictures meanwhile.
  void run_unseen(Index steps) {
    const Index end = simulation_->snapshot()->step + steps;
    simulation_->set_steps_per_snapshot(static_cast<int>(steps));
    simulation_->run();
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (simulation_->snapshot()->step < end &&
           simulation_->snapshot()->status == RunStatus::kRunning &&
           std::chrono::steady_clock::now() < patience) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    simulation_->pause();
    settle(*simulation_);
  }

  std::unique_ptr<Simulation> simulation_;
  Index tip_ = 0;
  Vector3 start_;
};

TEST_F(VertexDrags, StopAtTheGoalWhoeverLooks) {
  for (const auto& [integrator, step] :
       {std::pair(Integrator::kMidpoint, 5e-3), std::pair(Integrator::kBackwardEuler, 5e-3),
        std::pair(Integrator::kVerlet, 1e-4)}) {
    open(beam_scene(integrator, step));
    simulation_->grab({tip_});
    simulation_->run();
    const Vector3 goal = start_ + Vector3(0.02, 0.1, 0.03);
    simulation_->drag_to(goal);
    // How long the way takes depends on how fast the machine computes.
    for (int i = 0; i < 20 && (tip() - goal).norm() > 1e-6; ++i) {
      run_unseen(static_cast<Index>(1.0 / step));
    }
    run_unseen(10);
    EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning)
        << simulation_->snapshot()->message;
    EXPECT_LT((tip() - goal).norm(), 1e-6) << to_string(integrator);
    EXPECT_LT(vertex_block(simulation_->snapshot()->velocity, tip_).norm(), 1e-9);
    EXPECT_TRUE(is_held());
    release(*simulation_);
    EXPECT_FALSE(is_held());
    expect_nothing_refused();
  }
}

// The mouse is far away at once: the vertex follows no faster than the body can, and never beyond.
TEST_F(VertexDrags, HaveABoundedSpeed) {
  open(beam_scene(Integrator::kVerlet, 1e-4));
  const double sound = std::sqrt(1.5e6 / (2.0 * 1.4) / 1000.0);
  simulation_->grab({tip_});
  settle(*simulation_);
  simulation_->set_speed_limit(1e-3);  // so that the goal is wanted within a few steps
  simulation_->run();
  simulation_->drag_to(start_ + Vector3(0.0, 0.3, 0.0));
  simulation_->set_speed_limit(0.0);
  double highest = 0.0;
  double fastest = 0.0;
  simulation_->set_steps_per_snapshot(1);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (simulation_->snapshot()->time < 0.5 && std::chrono::steady_clock::now() < patience) {
    highest = std::max(highest, tip().y());
    fastest = std::max(fastest, vertex_block(simulation_->snapshot()->velocity, tip_).norm());
  }
  simulation_->pause();
  settle(*simulation_);
  EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning);
  EXPECT_LT((tip() - start_ - Vector3(0.0, 0.3, 0.0)).norm(), 1e-6);
  EXPECT_LT(highest, start_.y() + 0.3 + 1e-6);
  EXPECT_LE(fastest, 0.26 * sound);
  EXPECT_GT(fastest, 0.0);
}

TEST_F(VertexDrags, SeveralKeepTheirPlacesBesideTheFirst) {
  open(beam_scene(Integrator::kMidpoint, 5e-3));
  const Vector3 beside = vertex_block(simulation_->snapshot()->position, tip_ - 1) - start_;
  simulation_->grab({tip_, tip_ - 1});
  simulation_->drag_to(start_ + Vector3(0.0, 0.01, 0.0));  // paused: at once
  settle(*simulation_);
  EXPECT_LT((tip() - start_ - Vector3(0.0, 0.01, 0.0)).norm(), 1e-15);
  const auto offset = [&] {
    return Vector3(vertex_block(simulation_->snapshot()->position, tip_ - 1) - tip());
  };
  EXPECT_LT((offset() - beside).norm(), 1e-15);
  simulation_->run();
  simulation_->drag_to(start_ + Vector3(0.0, 0.05, 0.0));
  run_unseen(200);
  EXPECT_LT((tip() - start_ - Vector3(0.0, 0.05, 0.0)).norm(), 1e-6);
  EXPECT_LT((offset() - beside).norm(), 1e-9);
  release(*simulation_);
  EXPECT_FALSE(is_held());
  EXPECT_EQ(simulation_->undo_text(), "Drag 2 vertices");
}

TEST_F(VertexDrags, AFixedVertexStaysFixedWhereItIsLeft) {
  open(beam_scene(Integrator::kMidpoint, 5e-3));
  const Vector3 clamp = vertex_block(simulation_->snapshot()->position, 0);
  simulation_->grab({0});
  simulation_->run();
  simulation_->drag_to(clamp + Vector3(0.0, 0.02, 0.0));
  run_unseen(200);
  simulation_->release();
  make_steps(*simulation_, 20);
  EXPECT_EQ(simulation_->snapshot()->fixed[0], 1);
  EXPECT_LT(
      (vertex_block(simulation_->snapshot()->position, 0) - clamp - Vector3(0.0, 0.02, 0.0)).norm(),
      1e-6);
  undo(*simulation_);
  EXPECT_EQ(simulation_->snapshot()->fixed[0], 1);
}

// The button goes up after the run has failed, when nothing can be changed.
TEST_F(VertexDrags, AreReleasedAfterAFailure) {
  open(beam_scene(Integrator::kVerlet, 1e-4));
  simulation_->grab({tip_});
  simulation_->edit(SetTime{{Integrator::kVerlet, 1.0, false, 1.0}}, "far too large");
  make_steps(*simulation_, 20);
  simulation_->drag_to(start_ + Vector3(0.0, 0.02, 0.0));
  ASSERT_EQ(simulation_->snapshot()->status, RunStatus::kUnstable);
  simulation_->take_notices();  // of the steps that were asked for in vain
  release(*simulation_);
  go_back(*simulation_);
  EXPECT_EQ(simulation_->snapshot()->status, RunStatus::kRunning);
  EXPECT_FALSE(is_held());
  expect_nothing_refused();
}

TEST_F(VertexDrags, EndWithUndo) {
  open(beam_scene(Integrator::kMidpoint, 5e-3));
  simulation_->grab({tip_});
  simulation_->drag_to(start_ + Vector3(0.0, 0.02, 0.0));
  simulation_->undo();
  simulation_->drag_to(start_ + Vector3(0.0, 0.04, 0.0));
  release(*simulation_);
  EXPECT_FALSE(is_held());
  EXPECT_LT((tip() - start_).norm(), 1e-15);
  expect_nothing_refused();
}

// While the simulation is paused, a vertex is moved at once, and the body does not give way.
TEST_F(VertexDrags, StopWhereAnElementWouldBeInverted) {
  open(beam_scene(Integrator::kMidpoint, 5e-3));
  simulation_->grab({tip_});
  const Vector3 good = start_ + Vector3(0.01, 0.02, 0.0);
  simulation_->drag_to(good);
  settle(*simulation_);
  for (const double far : {0.5, 0.6}) simulation_->drag_to(start_ - Vector3(far, 0.0, 0.0));
  settle(*simulation_);
  EXPECT_LT((tip() - good).norm(), 1e-15);
  std::vector<std::string> refusals;
  for (const Notice& notice : simulation_->take_notices()) {
    if (notice.kind == Notice::Kind::kRefused) refusals.push_back(notice.text);
  }
  ASSERT_EQ(refusals.size(), 1U) << "one notice for all movements of the mouse";
  EXPECT_NE(refusals[0].find("would be inverted"), std::string::npos) << refusals[0];
  EXPECT_EQ(refusals[0].find("[["), std::string::npos) << "not a message about a scene file";
  EXPECT_EQ(refusals[0].find("initial."), std::string::npos) << refusals[0];
  // The drag goes on, and the vertex is free after it.
  const Vector3 better = start_ + Vector3(0.0, 0.03, 0.0);
  simulation_->drag_to(better);
  settle(*simulation_);
  EXPECT_LT((tip() - better).norm(), 1e-15);
  EXPECT_TRUE(is_held());
  simulation_->drag_to(start_ - Vector3(0.5, 0.0, 0.0));
  release(*simulation_);
  EXPECT_FALSE(is_held());
  simulation_->take_notices();
  undo(*simulation_);
  EXPECT_LT((tip() - start_).norm(), 1e-15);
  expect_nothing_refused();
}

}  // namespace
}  // namespace tetraction::viewer
