// Drags with the mouse, and runs that pause by themselves, in the window.
#include <QFile>
#include <QWheelEvent>
#include <cmath>

#include "tetraction/io/scene_reader.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Drags : public WindowTest {
 protected:
  // The cantilever of the report: 486 tetrahedra, 0.6 m long.
  static Document cantilever() {
    Document document = quiet_beam();
    document.scene.mesh.generate =
        GeneratorSettings{GeneratorKind::kBox, {0.6, 0.1, 0.1}, {9, 3, 3}};
    document.mesh = mesh_of(document.scene);
    document.scene.damping = {};
    return document;
  }
};

TEST_F(Drags, AnOrdinaryDragLeavesARunThatGoesOn) {
  show(cantilever());
  const Index tip = nearest({0.6, 0.1, 0.1});
  const Vector3 start = position(tip);
  trigger("tool_3");
  window_->simulation()->run();
  while_pressed_ = [&] {
    wait(400);
    EXPECT_TRUE(wait_for([&] { return (position(tip) - start).norm() > 0.05; }));
    keep_picture("spring_drag");
    EXPECT_FALSE(state().pulled.empty());
  };
  const double per_pixel =
      0.6 / std::abs(place_of(Vector3(0.6, 0.1, 0.1)).x() - place_of(Vector3(0.0, 0.1, 0.1)).x());
  drag(place_of(tip), place_of(tip) + QPoint(0, -static_cast<int>(0.32 / per_pixel)));
  const double end = state().time + 1.0;
  window_->simulation()->set_speed_limit(0.0);
  ASSERT_TRUE(wait_for([&] { return state().time > end || !state().running; }));
  EXPECT_EQ(state().status, RunStatus::kRunning) << state().message;
  EXPECT_EQ(state().pause, Pause::kNone);
  EXPECT_TRUE(state().pulled.empty());
  EXPECT_EQ(message(), QString());
  window_->simulation()->pause();
  settle();
  EXPECT_TRUE(QString::fromStdString(window_->simulation()->undo_text()).startsWith("Drag vertex"));
}

TEST_F(Drags, AltHoldsTheVertexWhereTheMouseIs) {
  show(cantilever());
  const Index tip = nearest({0.6, 0.1, 0.1});
  trigger("tool_3");
  settle();
  const QPoint from = place_of(tip);
  while_pressed_ = [&] {
    const auto distance = [&] { return (place_of(tip) - from - QPoint(0, -6)).manhattanLength(); };
    EXPECT_TRUE(wait_for([&] { return distance() < 3; }, 10000)) << distance();
    EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 1);
  };
  drag(from, from + QPoint(0, -6), Qt::AltModifier);
  settle();
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 0);
  EXPECT_LT(state().momentum.norm(), 1e-12);
}

TEST_F(Drags, TheWheelSetsTheArea) {
  show(cantilever());
  trigger("tool_3");
  std::size_t small = 0;
  std::size_t large = 0;
  while_pressed_ = [&] {
    settle();
    small = state().pulled.size();
    QWidget* canvas = window_->body_view()->canvas();
    const QPointF place(canvas->width() / 2.0, canvas->height() / 2.0);
    for (int i = 0; i < 4; ++i) {
      QWheelEvent wheel(place, canvas->mapToGlobal(place.toPoint()), QPoint(), QPoint(0, 120),
                        Qt::LeftButton, Qt::NoModifier, Qt::NoScrollPhase, false);
      QApplication::sendEvent(canvas, &wheel);
      settle();
    }
    large = state().pulled.size();
  };
  const QPoint from = place_of(nearest({0.6, 0.1, 0.1}));
  drag(from, from + QPoint(0, -30));
  EXPECT_GT(small, 1U);
  EXPECT_GT(large, small);
}

TEST_F(Drags, TheWindowsOwnSceneKeepsItsEnergy) {
  show(first_scene());
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kEnergyMomentum);
  EXPECT_GT(window_->simulation()->settings().time.retry, 0);
  const QString path = QDir::temp().filePath(QStringLiteral("tetraction_saved_first_scene.toml"));
  ASSERT_TRUE(window_->save_scene(path));
  const Scene saved = read_scene(path.toStdString());
  EXPECT_GT(saved.time.retry, 0);
  EXPECT_TRUE(std::isfinite(saved.time.end));
  QFile::remove(path);
}

TEST_F(Drags, ARunStopsAtItsEndAndOneButtonGoesOn) {
  Document document = quiet_beam();
  document.scene.time.end = 0.03;
  show(std::move(document));
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([this] { return action_button(QStringLiteral("Go on")) != nullptr; }));
  EXPECT_FALSE(state().running);
  EXPECT_NEAR(state().time, 0.03, 1e-12);
  expect_told(QStringLiteral("its end"));
  keep_picture("end_of_run");
  QTest::mouseClick(action_button(QStringLiteral("Go on")), Qt::LeftButton);
  ASSERT_TRUE(wait_for([this] { return state().time > 0.05; }));
  ASSERT_TRUE(wait_for([this] { return message().isEmpty(); }));
}

TEST_F(Drags, ALargeEnergyErrorPausesWithWaysOut) {
  Document document = cantilever();
  document.scene.time.integrator = Integrator::kMidpoint;
  document.scene.initial.velocity = {0.0, 12.0, 0.0};
  show(std::move(document));
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  const QString rule = QStringLiteral("energy-momentum");
  ASSERT_TRUE(wait_for([&] { return action_button(rule) != nullptr; }));
  EXPECT_EQ(state().pause, Pause::kEnergyError);
  keep_picture("energy_error");
  EXPECT_NE(action_button(QStringLiteral("Half the step")), nullptr);
  QTest::mouseClick(action_button(rule), Qt::LeftButton);
  const double end = state().time + 0.05;
  ASSERT_TRUE(wait_for([&] { return state().time > end; }));
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kEnergyMomentum);
  EXPECT_EQ(message(), QString());
}

}  // namespace
}  // namespace tetraction::viewer
