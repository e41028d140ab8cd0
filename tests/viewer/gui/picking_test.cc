// The mouse on the body.
#include <QPushButton>
#include <chrono>
#include <thread>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

using Picking = WindowTest;

TEST_F(Picking, AClickSelectsTheVertexThere) {
  show(quiet_beam());
  for (const Vector3& corner :
       {Vector3(1.2, 0.3, 0.3), Vector3(0.6, 0.3, 0.3), Vector3(0.6, 0.15, 0.3)}) {
    const Index vertex = nearest(corner);
    QTest::mouseClick(window_->body_view()->canvas(), Qt::LeftButton, Qt::NoModifier,
                      place_of(vertex));
    wait(50);
    EXPECT_EQ(window_->selection(), std::vector<Index>{vertex});
  }
  // One more with Ctrl; a click beside the body clears.
  const Index more = nearest({1.2, 0.3, 0.3});
  QTest::mouseClick(window_->body_view()->canvas(), Qt::LeftButton, Qt::ControlModifier,
                    place_of(more));
  EXPECT_EQ(window_->selection().size(), 2U);
  QTest::mouseClick(window_->body_view()->canvas(), Qt::LeftButton, Qt::NoModifier, QPoint(8, 200));
  EXPECT_TRUE(window_->selection().empty());
}

TEST_F(Picking, AVertexBehindTheBodyIsNotPicked) {
  show(quiet_beam());
  const Index behind = nearest({0.6, 0.15, 0.0});
  const Index picked = window_->body_view()->vertex_at(place_of(behind));
  EXPECT_GE(picked, 0);
  EXPECT_NE(picked, behind);
}

TEST_F(Picking, RubberBandAndFix) {
  show(quiet_beam());
  trigger("tool_2");
  const QPoint a = place_of(nearest({1.2, 0.3, 0.0}));
  const QPoint b = place_of(nearest({1.2, 0.0, 0.3}));
  drag(QPoint(std::max(a.x(), b.x()) + 20, std::min(a.y(), b.y()) - 40),
       QPoint(std::min(a.x(), b.x()) - 12, std::max(a.y(), b.y()) + 40));
  std::size_t at_the_end = 0;
  for (const Index v : window_->selection()) at_the_end += position(v).x() > 1.15;
  EXPECT_EQ(at_the_end, 9U);
  keep_picture("rubber_band");
  press_and_settle(Qt::Key_F);
  for (const Index v : window_->selection()) {
    EXPECT_EQ(state().fixed[static_cast<std::size_t>(v)], 1);
  }
  press_and_settle(Qt::Key_U);
  for (const Index v : window_->selection()) {
    EXPECT_EQ(state().fixed[static_cast<std::size_t>(v)], 0);
  }
}

TEST_F(Picking, AnExactDragMovesAVertexWhilePaused) {
  show(quiet_beam());
  trigger("tool_3");
  const Index tip = nearest({1.2, 0.3, 0.3});
  const Vector3 before = position(tip);
  const QPoint from = place_of(tip);
  bool held = false;
  while_pressed_ = [&] {
    settle();
    held = state().fixed[static_cast<std::size_t>(tip)] != 0;
  };
  drag(from, from + QPoint(0, -12), Qt::AltModifier);
  settle();
  EXPECT_TRUE(held);
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 0);
  EXPECT_GT(position(tip).y(), before.y() + 0.005);
  const QPoint now = place_of(tip);
  EXPECT_NEAR(now.x(), from.x(), 2);
  EXPECT_NEAR(now.y(), from.y() - 12, 2);
  EXPECT_FALSE(window_->simulation()->undo_text().empty());
}

TEST_F(Picking, AnExactDragPullsARunningBodyAndTellsTheReaction) {
  show(quiet_beam());
  trigger("tool_3");
  press_key(Qt::Key_Space);
  ASSERT_TRUE(wait_for([&] { return state().step > 2; }));
  const Index tip = nearest({1.2, 0.3, 0.3});
  double reaction = 0.0;
  double height = 0.0;
  while_pressed_ = [&] {
    // The vertex moves at once, the rest of the body pulls it back a little later.
    EXPECT_TRUE(wait_for([&] {
      return position(tip).y() > 0.305 && vertex_block(state().reaction_force, tip).norm() > 0.1;
    }));
    reaction = vertex_block(state().reaction_force, tip).norm();
    height = position(tip).y();
    keep_picture("dragging");
  };
  const QPoint from = place_of(tip);
  drag(from, from + QPoint(0, -15), Qt::AltModifier);
  EXPECT_GT(height, 0.305);
  EXPECT_GT(reaction, 0.1);
  settle_running();
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 0);
  EXPECT_EQ(state().status, RunStatus::kRunning);
}

// The window has no time for pictures while the solver goes on: the vertex stops where the mouse is.
TEST_F(Picking, ADraggedVertexDoesNotOvershootWhenPicturesLag) {
  Document document = quiet_beam();
  document.scene.time.integrator = Integrator::kVerlet;
  document.scene.time.step = 2e-4;
  show(std::move(document));
  trigger("tool_3");
  press_key(Qt::Key_Space);
  ASSERT_TRUE(wait_for([&] { return state().step > 2; }));
  const Index tip = nearest({1.2, 0.3, 0.3});
  const Vector3 start = position(tip);
  const QPoint from = place_of(tip);
  QWidget* canvas = window_->body_view()->canvas();
  QTest::mousePress(canvas, Qt::LeftButton, Qt::AltModifier, from);
  wait(200);
  QTest::mouseMove(canvas, from + QPoint(0, -20));
  ASSERT_TRUE(wait_for([&] { return place_of(tip).y() <= from.y() - 18; }));
  const double half_way = position(tip).y();
  QTest::mouseMove(canvas, from + QPoint(0, -40));
  // Until the solver has heard of it, at most.
  ASSERT_TRUE(
      wait_for([&] { return position(tip).y() > half_way + 0.2 * (half_way - start.y()); }));
  // One second of the simulation, which may take longer on a busy machine.
  const double end = state().time + 1.0;
  double highest = 0.0;
  for (int i = 0; i < 1200 && (i < 20 || state().time < end); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    highest = std::max(highest, position(tip).y());
  }
  const QPoint there = place_of(tip);
  QTest::mouseRelease(canvas, Qt::LeftButton, Qt::AltModifier, from + QPoint(0, -40));
  EXPECT_NEAR(there.x(), from.x(), 2);
  EXPECT_NEAR(there.y(), from.y() - 40, 2);
  EXPECT_NEAR(position(tip).y(), highest, 0.3 * (highest - start.y()));
  EXPECT_EQ(state().status, RunStatus::kRunning);
}

TEST_F(Picking, ArrowsPullForceAndMomentum) {
  show(quiet_beam());
  const Index tip = nearest({1.2, 0.3, 0.3});
  trigger("tool_4");
  while_pressed_ = [&] { keep_picture("arrow"); };
  drag(place_of(tip), place_of(tip) + QPoint(0, -60));
  settle();
  EXPECT_GT(vertex_block(state().external_force, tip).y(), 0.0);
  while_pressed_ = [] {};
  trigger("tool_5");
  drag(place_of(tip), place_of(tip) + QPoint(0, -60));
  settle();
  EXPECT_GT(vertex_block(state().momentum, tip).y(), 0.0);
}

TEST_F(Picking, TurningTheCameraLeavesTheBodyAlone) {
  show(quiet_beam());
  const QPoint before = place_of(nearest({1.2, 0.3, 0.3}));
  drag(QPoint(200, 200), QPoint(300, 240));
  EXPECT_GT((place_of(nearest({1.2, 0.3, 0.3})) - before).manhattanLength(), 5);
  EXPECT_TRUE(window_->simulation()->undo_text().empty());
}

}  // namespace
}  // namespace tetraction::viewer
