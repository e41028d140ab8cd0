// A body that leaves the picture, and the ways to it.
#include <QToolButton>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Camera : public WindowTest {
 protected:
  // A free body that flies to the right.
  static Document flying(double speed) {
    Document document = quiet_beam();
    document.scene.fix.clear();
    document.scene.damping = {};
    document.scene.initial.velocity = {speed, 0.0, 0.0};
    return document;
  }
  // The direction from left to right in the picture, as a line in space.
  double slope() {
    const QPoint a = place_of(nearest({0.0, 0.0, 0.0}));
    const QPoint b = place_of(nearest({1.2, 0.0, 0.0}));
    return static_cast<double>(b.y() - a.y()) / (b.x() - a.x());
  }
};

TEST_F(Camera, HomeKeepsTheDirection) {
  show(quiet_beam());
  drag(QPoint(200, 200), QPoint(380, 330));  // turns the camera
  const double before = slope();
  press_key(Qt::Key_Home);
  wait();
  EXPECT_NEAR(slope(), before, 0.03);
  press_key(Qt::Key_O);
  wait();
  EXPECT_GT(std::abs(slope() - before), 0.05) << "the oblique view is another one";
}

TEST_F(Camera, AnArrowAtTheEdgePointsToABodyOutside) {
  show(flying(200.0));
  QToolButton* mark = window_->body_view()->edge_mark();
  EXPECT_FALSE(mark->isVisible());
  run_to(0.2);
  ASSERT_TRUE(wait_for([&] { return mark->isVisible(); }, 5000));
  EXPECT_EQ(mark->arrowType(), Qt::RightArrow);
  QWidget* canvas = window_->body_view()->canvas();
  EXPECT_TRUE(canvas->rect().contains(mark->geometry()));
  EXPECT_GT(mark->geometry().center().x(), canvas->width() / 2);
  keep_picture("edge_mark");
  QTest::mouseClick(mark, Qt::LeftButton);
  wait();
  EXPECT_FALSE(mark->isVisible());
  EXPECT_TRUE(canvas->rect().contains(place_of(nearest({1.2, 0.3, 0.3}))));
  // After a restart the body is where it began, and the picture shows it.
  press_and_settle(Qt::Key_R);
  EXPECT_TRUE(canvas->rect().contains(place_of(nearest({1.2, 0.3, 0.3}))));
  EXPECT_FALSE(mark->isVisible());
}

TEST_F(Camera, FollowsTheBody) {
  show(flying(200.0));
  const QPoint before = place_of(nearest({1.2, 0.3, 0.3}));
  find<QAction>("follow")->trigger();
  run_to(0.2);
  EXPECT_GT(position(0).x(), 30.0);
  EXPECT_LT((place_of(nearest({1.2, 0.3, 0.3})) - before).manhattanLength(), 6);
}

}  // namespace
}  // namespace tetraction::viewer
