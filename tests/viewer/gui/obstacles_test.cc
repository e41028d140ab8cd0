// Obstacles in the picture.
#include <QCheckBox>
#include <QTemporaryDir>
#include <algorithm>
#include <iterator>

#include "pictures.h"
#include "tetraction/io/run_recorder.h"
#include "viewer/gui/replay/replay.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

// A plane below the beam, which nothing touches.
ObstacleSettings floor_at(double y) {
  ObstacleSettings floor;
  floor.name = "floor";
  floor.kind = ObstacleKind::kPlane;
  floor.point = {0.0, y, 0.0};
  return floor;
}

ObstacleSettings ball(const Vector3& center, double radius) {
  ObstacleSettings ball;
  ball.name = "ball";
  ball.kind = ObstacleKind::kSphere;
  ball.center = center;
  ball.radius = radius;
  return ball;
}

class Obstacles : public WindowTest {
 protected:
  static Document beam_with(std::vector<ObstacleSettings> obstacles) {
    Document document = quiet_beam();
    document.scene.obstacle = std::move(obstacles);
    return document;
  }
  void show_with(std::vector<ObstacleSettings> obstacles) {
    show(beam_with(std::move(obstacles)));
    window_->messages()->clear();
    raise("dock_drawing");
  }
  // The picture with and without obstacles: whether it differs around a place.
  bool is_drawn_at(const Vector3& point) {
    const QImage with = picture();
    click("obstacles");
    const QImage without = picture();
    click("obstacles");
    return differ_at(with, without, place_of(point), 1);
  }
  BodyView::Camera camera() { return window_->body_view()->camera(); }
};

TEST_F(Obstacles, AreDrawnBehindTheBodyAndCanBeHidden) {
  show_with({floor_at(-0.1), ball({0.6, 0.8, 0.15}, 0.25)});
  EXPECT_TRUE(find<QCheckBox>("obstacles")->isChecked());
  const Vector3 beside(0.6, -0.1, 0.5);
  const Vector3 on_ball(0.62, 0.82, 0.4);
  const Vector3 front(0.675, 0.18, 0.3);  // of the body
  EXPECT_TRUE(is_drawn_at(beside));
  EXPECT_TRUE(is_drawn_at(on_ball));
  EXPECT_FALSE(is_drawn_at(front));
  keep_picture("obstacles");
  press_key_in("background", Qt::Key_End);
  EXPECT_TRUE(is_drawn_at(beside));
  EXPECT_TRUE(is_drawn_at(on_ball));
  keep_picture("obstacles_dark");
}

TEST_F(Obstacles, WallsBetweenTheCameraAndTheBodyAreGridsOnly) {
  ObstacleSettings room;
  room.name = "room";
  room.kind = ObstacleKind::kBox;
  room.inside = true;
  room.min = {-0.4, -0.4, -0.4};
  room.max = {1.6, 0.8, 0.8};
  show_with({room});
  window_->body_view()->look_from(Vector3::UnitZ());
  // The nearer wall has lines every eighth, which leave the rest of the body's front as it is.
  EXPECT_FALSE(is_drawn_at({0.72, 0.12, 0.3}));
  EXPECT_TRUE(is_drawn_at({0.72, 0.6, -0.4}));  // the wall behind the body
  keep_picture("room");
}

TEST_F(Obstacles, MoveWithTheTimeOfTheState) {
  ObstacleSettings moving = ball({0.6, 0.7, 0.15}, 0.2);
  moving.velocity = {1.0, 0.0, 0.0};
  Document document = beam_with({moving});
  document.scene.environment.kind = EnvironmentKind::kGravity;
  show(std::move(document));
  raise("dock_drawing");
  const Vector3 at_start(0.45, 0.7, 0.15);
  const Vector3 later(1.15, 0.7, 0.15);
  EXPECT_TRUE(is_drawn_at(at_start));
  EXPECT_FALSE(is_drawn_at(later));
  // Single steps: a run may move the ball out of the picture before it is paused.
  while (state().time < 0.5) {
    const Index before = state().step;
    window_->simulation()->step();
    ASSERT_TRUE(wait_for([&] { return state().step > before; }));
  }
  settle();
  EXPECT_FALSE(is_drawn_at(at_start));
  EXPECT_TRUE(is_drawn_at({0.6 + state().time, 0.7, 0.15}));
}

TEST_F(Obstacles, HomeShowsTheBodyAndNotThePlane) {
  show(quiet_beam());
  press_key(Qt::Key_Home);
  wait();
  const BodyView::Camera alone = camera();
  show_with({floor_at(-0.1), ball({0.0, -2000.0, 0.0}, 1500.0)});
  press_key(Qt::Key_Home);
  wait();
  const BodyView::Camera with = camera();
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_NEAR(with[i], alone[i], 1e-9) << i;
  // A large obstacle takes no depth from the picture of the body.
  EXPECT_TRUE(is_drawn_at({0.6, -0.1, 0.5}));
  EXPECT_FALSE(is_drawn_at({0.675, 0.18, 0.3}));
}

TEST_F(Obstacles, AreNoHindranceToTheMouse) {
  // A ball between the camera and the beam.
  const auto pick = [this] {
    const Index vertex = nearest({0.6, 0.3, 0.3});
    QTest::mouseClick(window_->body_view()->canvas(), Qt::LeftButton, Qt::NoModifier,
                      place_of(vertex));
    wait(50);
    EXPECT_EQ(window_->selection(), std::vector<Index>{vertex});
  };
  const auto band = [this] {
    trigger("tool_2");
    const QPoint a = place_of(nearest({0.0, 0.3, 0.0}));
    const QPoint b = place_of(nearest({1.2, 0.0, 0.3}));
    const QRect box = QRect(a, b).normalized().adjusted(-40, -80, 40, 80);
    drag(box.topLeft(), box.bottomRight());
    return window_->selection();
  };
  show(quiet_beam());
  raise("dock_drawing");
  const std::vector<Index> without = band();
  EXPECT_GT(without.size(), 20U);
  show_with({floor_at(-0.1), ball({0.8, 0.6, 1.2}, 0.4)});
  const std::vector<Index> with = band();
  std::vector<Index> others;
  std::ranges::set_symmetric_difference(with, without, std::back_inserter(others));
  EXPECT_EQ(others, std::vector<Index>()) << "vertices that only one of the bands has";
  pick();
}

TEST_F(Obstacles, ContactForcesHaveArrows) {
  // The beam is in the layer, whose thickness is a tenth of the mean edge, which is longer than 0.15 m.
  Document document = beam_with({floor_at(-0.005)});
  show(std::move(document));
  raise("dock_drawing");
  EXPECT_GT(state().contact_force.maxCoeff(), 0.0);
  const QImage without = picture();
  click("contacts");
  EXPECT_GT(differing_pixels(picture(), without), 100);
  keep_picture("contact_forces");
}

TEST_F(Obstacles, AReplayDrawsThoseOfItsFrames) {
  ObstacleSettings moving = ball({0.6, 0.7, 0.15}, 0.2);
  moving.velocity = {1.0, 0.0, 0.0};
  const QTemporaryDir folder;
  const std::string run = folder.filePath(QStringLiteral("run")).toStdString();
  Document document = beam_with({floor_at(-0.1), moving});
  document.scene.environment.kind = EnvironmentKind::kGravity;
  document.scene.time.step = 1e-2;
  document.scene.time.end = 0.5;
  {
    RunRecorder recorder(run, 10);
    Session session(document.scene, document.mesh);
    session.run({&recorder});
  }
  open(QString::fromStdString(run));
  ASSERT_NE(window_->replay(), nullptr);
  ASSERT_EQ(window_->replay()->times().size(), 6U);
  raise("dock_drawing");
  const auto frame = [this](std::size_t i) { return window_->replay()->frame(i, {}); };
  ASSERT_NE(frame(0)->obstacles, nullptr);
  EXPECT_NE(*frame(0)->obstacles, *frame(5)->obstacles);
  EXPECT_TRUE(is_drawn_at({0.6, -0.1, 0.5}));
  EXPECT_TRUE(is_drawn_at({0.45, 0.7, 0.15}));
  EXPECT_FALSE(is_drawn_at({1.15, 0.7, 0.15}));
}

}  // namespace
}  // namespace tetraction::viewer
