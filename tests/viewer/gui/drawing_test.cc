// The panel of what is drawn, and the picture that comes of it.
#include <QCheckBox>
#include <QComboBox>
#include <QSlider>
#include <algorithm>

#include "pictures.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Drawing : public WindowTest {
 protected:
  double low() { return window_->body_view()->color_low(); }
  double high() { return window_->body_view()->color_high(); }
  const DrawingSettings& drawing() { return window_->body_view()->drawing(); }
};

// Points on the beam's front, in no edge of the mesh; on its end; on its top.
const Vector3 kFront(1.125, 0.18, 0.3), kFrontLeft(0.225, 0.18, 0.3), kFrontLow(0.525, 0.03, 0.3),
    kEnd(1.2, 0.18, 0.225), kTop(0.525, 0.3, 0.18);

TEST_F(Drawing, LightComesFromWhereTheSlidersSay) {
  show_beam();
  click("edges");
  const auto at = [this](const Vector3& point) { return brightness(picture(), place_of(point)); };
  press_key_in("light_azimuth", Qt::Key_Home);
  EXPECT_EQ(drawing().light_azimuth, -90.0);
  const double end_from_left = at(kEnd);
  keep_picture("light_left");
  press_key_in("light_azimuth", Qt::Key_End);
  EXPECT_EQ(drawing().light_azimuth, 90.0);
  EXPECT_GT(at(kEnd), end_from_left + 8.0);

  press_key_in("light_elevation", Qt::Key_Home);
  const double top_from_below = at(kTop);
  press_key_in("light_elevation", Qt::Key_End);
  EXPECT_EQ(drawing().light_elevation, 90.0);
  EXPECT_GT(at(kTop), top_from_below + 8.0);
  keep_picture("light_top");

  // By the mouse, too: down and to the left.
  QWidget* canvas = window_->body_view()->canvas();
  const QPoint from(300, 200);
  QTest::mousePress(canvas, Qt::RightButton, Qt::ControlModifier, from);
  QTest::mouseMove(canvas, from + QPoint(-150, 100));
  QTest::mouseRelease(canvas, Qt::RightButton, Qt::ControlModifier, from + QPoint(-150, 100));
  EXPECT_NEAR(drawing().light_azimuth, 30.0, 1.0);
  EXPECT_NEAR(drawing().light_elevation, 50.0, 1.0);
  QTest::mouseMove(canvas, from);
  EXPECT_NEAR(drawing().light_azimuth, 30.0, 1.0);
}

TEST_F(Drawing, BackgroundIsLightWhiteOrDark) {
  show_beam();
  const auto corners = [this] {
    const QImage image = picture();
    const int right = image.width() - 3;
    return std::vector<int>{qGray(image.pixel(right, 2)), qGray(image.pixel(2, 2)),
                            qGray(image.pixel(right, image.height() - 3))};
  };
  for (const int gray : corners()) EXPECT_GT(gray, 180);
  press_key_in("background", Qt::Key_End);
  for (const int gray : corners()) EXPECT_LT(gray, 90);
  keep_picture("dark");
  press_key_in("background", Qt::Key_Up);
  for (const int gray : corners()) EXPECT_EQ(gray, 255);
}

TEST_F(Drawing, SurfaceEdgesAndPointsAlone) {
  show_beam();
  const QPoint face = place_of(kFront);
  const QPoint edge = place_of(Vector3(1.125, 0.3, 0.3));
  const QPoint vertex = place_of(Vector3(1.05, 0.3, 0.3));
  for (const char* name : {"surface", "edges", "fixed"}) click(name);
  const QImage empty = picture();
  const auto shows = [&](const QPoint& place) { return differ_at(picture(), empty, place, 1); };
  EXPECT_FALSE(shows(face));
  click("surface");
  EXPECT_TRUE(shows(face));
  click("surface");
  EXPECT_EQ(differing_pixels(picture(), empty), 0);
  click("edges");
  EXPECT_FALSE(shows(face));
  EXPECT_TRUE(shows(edge));
  keep_picture("edges_alone");
  click("edges");
  click("points");
  EXPECT_FALSE(shows(face));
  EXPECT_FALSE(shows(edge));
  EXPECT_TRUE(shows(vertex));
  keep_picture("points_alone");
  click("fixed");
  EXPECT_TRUE(shows(place_of(Vector3(0.0, 0.3, 0.3))));
}

TEST_F(Drawing, TypedRangeIsKeptWhileRunning) {
  show(first_scene());
  raise("dock_drawing");
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().time > 0.1; }));
  auto* from = find<NumberField>("range_low");
  auto* to = find<NumberField>("range_high");
  auto* follow = find<QCheckBox>("automatic_range");
  type(to, "54321");
  type(from, "123");
  EXPECT_EQ(low(), 123.0);
  EXPECT_EQ(high(), 54321.0);
  EXPECT_FALSE(follow->isChecked());
  const double time = state().time;
  ASSERT_TRUE(wait_for([&] { return state().time > time + 0.2; }));
  wait(200);
  EXPECT_EQ(low(), 123.0);
  EXPECT_EQ(high(), 54321.0);
  EXPECT_EQ(to->text(), QStringLiteral("54321"));

  // Lowest above highest: refused, also when something else is changed after it.
  type(from, "6e4");
  expect_told(QStringLiteral("below the highest"));
  click("points");
  EXPECT_EQ(low(), 123.0);
  EXPECT_EQ(high(), 54321.0);
  EXPECT_EQ(from->text(), QStringLiteral("123"));
  keep_picture("fixed_range");

  click("automatic_range");
  EXPECT_TRUE(follow->isChecked());
  ASSERT_TRUE(wait_for([&] { return state().time > time + 0.4; }));
  EXPECT_EQ(low(), 0.0);
  EXPECT_NE(high(), 54321.0);
}

TEST_F(Drawing, ARestartAndFitNowFitTheColoursOfThatMoment) {
  show(first_scene());
  raise("dock_drawing");
  run_to(0.3);
  const double loaded = high();
  ASSERT_GT(loaded, 1000.0);
  // A restart begins with the colours of a body at rest.
  press_and_settle(Qt::Key_R);
  EXPECT_LT(high(), 1.0);

  // A range that was typed is fitted, too, and then stays.
  run_to(0.3);
  type(find<NumberField>("range_high"), "1e7");
  EXPECT_EQ(high(), 1e7);
  click("fit_colors");
  const std::vector<float>& values = state().field_values;
  const double most = *std::max_element(values.begin(), values.end());
  const double fitted = high();  // rounded up, so that the bar has short numbers
  EXPECT_GE(fitted, most);
  EXPECT_LT(fitted, 1.35 * most);
  EXPECT_FALSE(drawing().automatic_range);
  EXPECT_EQ(find<NumberField>("range_high")->value(), high());
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(high(), fitted);
}

TEST_F(Drawing, ABodyWithoutColoursHasNoBar) {
  show(falling_beam());
  // Dark pixels of numbers and title beside the body.
  const auto has_bar = [this] {
    const QImage image = picture();
    int dark = 0;
    for (int x = image.width() - 100; x < image.width() - 10; ++x) {
      for (int y = image.height() / 4; y < 3 * image.height() / 4; ++y) {
        if (qGray(image.pixel(x, y)) < 90) ++dark;
      }
    }
    return dark > 50;
  };
  EXPECT_FALSE(has_bar());
  run_to(0.05);
  EXPECT_TRUE(has_bar());
  press_and_settle(Qt::Key_R);
  EXPECT_FALSE(has_bar());
}

TEST_F(Drawing, ClipPlaneHidesOneSide) {
  show_beam();
  const auto front = [this](const Vector3& point) {
    const Index v = window_->body_view()->vertex_at(place_of(point));
    return v >= 0 && (position(v) - point).norm() < 0.1;
  };
  const QImage whole = picture();
  const auto drawn = [&](const Vector3& point) {
    // The point can be picked if and only if it is seen.
    const bool seen = !differ_at(picture(), whole, place_of(point));
    EXPECT_EQ(seen, front(point)) << point.transpose();
    return seen;
  };
  EXPECT_TRUE(drawn(kFront) && drawn(kFrontLeft));
  click("clip");
  EXPECT_FALSE(drawn(kFront));
  EXPECT_TRUE(drawn(kFrontLeft));
  keep_picture("clip_x");
  click("clip_flipped");
  EXPECT_TRUE(drawn(kFront));
  EXPECT_FALSE(drawn(kFrontLeft));
  press_key_in("clip_at", Qt::Key_Home);
  EXPECT_TRUE(drawn(kFrontLeft));
  press_key_in("clip_at", Qt::Key_PageUp);
  EXPECT_GT(drawing().clip_at, 0.0);
  EXPECT_LT(drawing().clip_at, 0.5);
  click("clip_flipped");
  press_key_in("clip_axis", Qt::Key_Down);
  EXPECT_EQ(drawing().clip_axis, 1);
  press_key_in("clip_at", Qt::Key_End);
  EXPECT_TRUE(drawn(kFront) && drawn(kFrontLow));
  for (int i = 0; i < 5; ++i) press_key_in("clip_at", Qt::Key_PageDown);
  EXPECT_FALSE(drawn(kTop));
  EXPECT_TRUE(drawn(kFrontLow));
  keep_picture("clip_y");
  press_key_in("clip_axis", Qt::Key_End);
  EXPECT_EQ(drawing().clip_axis, 2);
  EXPECT_FALSE(drawn(kFrontLow));
  click("clip");
  EXPECT_TRUE(drawn(kFront) && drawn(kFrontLeft) && drawn(kFrontLow));
}

TEST_F(Drawing, ArrowsHaveTheLengthOfTheSlider) {
  show_beam();
  const Index tip = nearest({1.2, 0.3, 0.3});
  window_->select({tip});
  raise("dock_vertices");
  enter(find<NumberField>("force_x"), "5");
  raise("dock_drawing");
  const auto red = [](QRgb c) { return qRed(c) > 3 * qGreen(c) && qRed(c) > 3 * qBlue(c); };
  // How far red goes to the right of the vertex, in pixels.
  const auto reach = [&] {
    int most = 0;
    for (const QPoint& p : pixels(picture(), red)) most = std::max(most, p.x() - place_of(tip).x());
    return most;
  };
  const int usual = reach();
  EXPECT_GT(usual, 40);
  keep_picture("arrow_usual");
  press_key_in("arrow_scale", Qt::Key_PageUp);
  EXPECT_NEAR(drawing().arrow_scale, 2.0, 1e-12);
  EXPECT_NEAR(reach(), 2.0 * usual, 0.25 * usual);  // perspective
  press_key_in("arrow_scale", Qt::Key_Home);
  EXPECT_NEAR(drawing().arrow_scale, 0.1, 1e-12);
  EXPECT_LT(reach(), 0.2 * usual);
  click("forces");
  EXPECT_EQ(reach(), 0);
}

TEST_F(Drawing, AttractionCentreIsSeenWhileThereIsAttraction) {
  Document document = quiet_beam();
  for (Vector3& x : document.mesh.vertices.own()) x.y() += 0.2;  // the origin is free
  show(std::move(document));
  show_entry("environment");
  const QPoint center = place_of(Vector3::Zero());
  const QImage before = picture();
  const auto seen = [&] { return differ_at(picture(), before, center); };
  ASSERT_TRUE(before.rect().adjusted(20, 20, -20, -20).contains(center));
  const auto choose = [&](int key) {
    press_key_in("kind", key);
    settle();
  };
  choose(Qt::Key_Down);
  EXPECT_EQ(window_->simulation()->settings().environment.kind, EnvironmentKind::kGravity);
  EXPECT_FALSE(seen());
  choose(Qt::Key_Down);
  EXPECT_EQ(window_->simulation()->settings().environment.kind, EnvironmentKind::kAttraction);
  EXPECT_TRUE(seen());
  raise("dock_drawing");
  keep_picture("attraction");
  click("center");
  EXPECT_FALSE(seen());
  click("center");
  EXPECT_TRUE(seen());
  show_entry("environment");
  choose(Qt::Key_Home);
  EXPECT_FALSE(seen());
}

}  // namespace
}  // namespace tetraction::viewer
