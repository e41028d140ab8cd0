// What the picture of the body shows: colours and their values, views, shapes.
#include <QCheckBox>
#include <QComboBox>
#include <QLabel>
#include <QMenu>
#include <algorithm>

#include "pictures.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

// Points on the beam's front, top and end, in no edge of the mesh.
const Vector3 kFront(1.125, 0.18, 0.3), kTop(0.525, 0.3, 0.18), kEnd(1.2, 0.18, 0.225);

class Picture : public WindowTest {
 protected:
  BodyView& view() { return *window_->body_view(); }
  void draw(const std::function<void(DrawingSettings&)>& change) {
    DrawingSettings drawing = view().drawing();
    change(drawing);
    view().set_drawing(drawing);
    wait(50);
  }
  // Displacements from 0 to 1 m as colours, of a body at rest.
  void color_at_rest() {
    draw([](DrawingSettings& drawing) {
      drawing.field = find_quantity("displacement");
      drawing.automatic_range = false;
      drawing.edges = false;
    });
    window_->simulation()->set_color_field(find_quantity("displacement"));
    settle();
  }
  QPoint cube() {
    const QWidget* canvas = view().canvas();
    const int gutter = view().drawing().field != nullptr ? 120 : 0;
    return {canvas->width() - gutter - 8 - 44, canvas->height() - 8 - 44};
  }
  void click_at(const QPoint& place, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QTest::mouseClick(view().canvas(), Qt::LeftButton, modifiers, place);
    wait(50);
  }
  QLabel* value() { return find<QLabel>("value_text"); }
  bool is_neutral(const Vector3& point) {
    const QRgb color = picture().pixel(place_of(point));
    return qRed(color) > 0.7 * qBlue(color) && qBlue(color) > qGreen(color);
  }
};

TEST_F(Picture, TheBodyHasANeutralColourUntilItMoves) {
  show(falling_beam());
  draw([](DrawingSettings& drawing) { drawing.edges = drawing.forces = false; });
  const Vector3 point(0.525, 0.18, 0.3);
  EXPECT_TRUE(is_neutral(point));
  run_to(0.05);
  EXPECT_FALSE(is_neutral(point));
  press_and_settle(Qt::Key_R);
  EXPECT_TRUE(is_neutral(point));
}

// The stresses of round-off in a stiff body that is loaded and has not moved had a range of 2 mPa.
TEST_F(Picture, RoundOffHasTheNeutralColour) {
  Document document = falling_beam();
  document.scene.material.youngs_modulus = 2.1e11;
  const Vector3 shift = 100.0 * Vector3::Ones();
  document.scene.initial.displacement = shift;
  document.scene.initial.velocity = Vector3(1.0, 2.0, 3.0);
  document.scene.fix.clear();
  document.scene.environment.kind = EnvironmentKind::kNone;
  document.scene.time.step = 1e-5;
  show(std::move(document));
  draw([](DrawingSettings& drawing) {
    drawing.edges = drawing.forces = false;
    drawing.field = find_quantity("von_mises");
  });
  window_->simulation()->set_color_field(find_quantity("von_mises"));
  window_->simulation()->step();
  settle();
  const std::vector<float> values = view().state()->field_values;
  EXPECT_GT(*std::max_element(values.begin(), values.end()), 1e-3F) << "there is round-off";
  press_key(Qt::Key_Home);
  EXPECT_TRUE(is_neutral(Vector3(Vector3(0.525, 0.18, 0.3) + shift)));
}

TEST_F(Picture, ColoursAreThoseOfTheBar) {
  show_beam();
  color_at_rest();
  const auto expect_color = [&](const Vector3& point, int r, int g, int b) {
    const QRgb color = picture().pixel(place_of(point));
    EXPECT_NEAR(qRed(color), r, 2);
    EXPECT_NEAR(qGreen(color), g, 2);
    EXPECT_NEAR(qBlue(color), b, 2);
  };
  draw([](DrawingSettings& drawing) { drawing.shaded = false; });
  for (const Vector3& point : {kFront, kTop, kEnd}) expect_color(point, 68, 1, 84);
  draw([](DrawingSettings& drawing) { drawing.map = ColorMap::kCividis; });
  expect_color(kFront, 0, 34, 78);
  draw([](DrawingSettings& drawing) { drawing.map = ColorMap::kCoolToWarm; });
  expect_color(kFront, 59, 76, 192);
  draw([](DrawingSettings& drawing) { drawing.map = ColorMap::kGray; });
  expect_color(kFront, 26, 26, 26);
  // With light they are darker, and no brighter.
  draw([](DrawingSettings& drawing) {
    drawing.shaded = true;
    drawing.map = ColorMap::kCoolToWarm;
  });
  for (const Vector3& point : {kFront, kTop, kEnd}) {
    const QRgb color = picture().pixel(place_of(point));
    EXPECT_LE(qBlue(color), 194);
    EXPECT_GT(qBlue(color), 105);
    EXPECT_NEAR(qRed(color) / static_cast<double>(qBlue(color)), 59.0 / 192.0, 0.03);
  }
}

TEST_F(Picture, TheValueUnderTheMouseIsWritten) {
  show_beam();
  color_at_rest();
  EXPECT_FALSE(value()->isVisible());
  QTest::mouseMove(view().canvas(), place_of(kFront));
  ASSERT_TRUE(wait_for([&] { return value()->isVisible(); }, 2000));
  EXPECT_EQ(value()->text(), QStringLiteral("Displacement 0 m"));
  keep_picture("value");
  QTest::mouseMove(view().canvas(), QPoint(8, 200));
  EXPECT_TRUE(wait_for([&] { return !value()->isVisible(); }, 2000));
  // While it moves, the value follows without the mouse.
  window_->simulation()->edit(SetEnvironment{falling_beam().scene.environment}, "gravity");
  QTest::mouseMove(view().canvas(), place_of(kFront));
  run_to(0.1);
  EXPECT_TRUE(value()->isVisible());
  EXPECT_NE(value()->text(), QStringLiteral("Displacement 0 m"));
}

TEST_F(Picture, ComponentsOfFieldsAreDrawn) {
  show(falling_beam());
  raise("dock_drawing");
  auto* list = find<QComboBox>("color_field");
  list->setFocus(Qt::TabFocusReason);
  list->setCurrentIndex(list->findText(QStringLiteral("Displacement y [m]")));
  ASSERT_GT(list->currentIndex(), 0);
  emit list->activated(list->currentIndex());
  run_to(0.1);
  const std::vector<float>& values = state().field_values;
  for (const Index v : {Index{20}, Index{80}}) {
    const double there = position(v).y() - window_->simulation()->mesh().vertices[v].y();
    EXPECT_NEAR(values[static_cast<std::size_t>(v)], there, 1e-6);
  }
  EXPECT_EQ(view().color_low(), -view().color_high());
}

TEST_F(Picture, ViewsFromSixSidesAndWithoutPerspective) {
  show_beam();
  press_key(Qt::Key_P);
  struct View {
    Qt::Key key;
    Qt::KeyboardModifiers modifiers;
    Vector3 from;
  };
  const Qt::KeyboardModifiers shift = Qt::ShiftModifier;
  for (const View& each :
       {View{Qt::Key_X, Qt::NoModifier, {1, 0, 0}}, View{Qt::Key_X, shift, {-1, 0, 0}},
        View{Qt::Key_Y, Qt::NoModifier, {0, 1, 0}}, View{Qt::Key_Y, shift, {0, -1, 0}},
        View{Qt::Key_Z, Qt::NoModifier, {0, 0, 1}}, View{Qt::Key_Z, shift, {0, 0, -1}}}) {
    press_key(each.key, each.modifiers);
    wait(50);
    const Vector3 middle(0.6, 0.15, 0.15);
    // Points one behind the other are drawn at one place, and the front one is picked.
    const QPoint near = place_of(middle + 0.1 * each.from);
    EXPECT_EQ(near, place_of(middle - 0.1 * each.from)) << each.from.transpose();
    const Index picked = view().vertex_at(near);
    ASSERT_GE(picked, 0);
    EXPECT_GT((position(picked) - middle).dot(each.from), 0.1) << each.from.transpose();
  }
  // The perspective comes back with the size.
  const int wide = place_of(Vector3(1.2, 0.15, 0.15)).x() - place_of(Vector3(0.0, 0.15, 0.15)).x();
  press_key(Qt::Key_P);
  wait(50);
  const int now = place_of(Vector3(1.2, 0.15, 0.15)).x() - place_of(Vector3(0.0, 0.15, 0.15)).x();
  EXPECT_NEAR(now, wide, 3);
}

TEST_F(Picture, AClickOnTheCubeLooksFromItsFace) {
  show_beam();
  const QImage with = picture();
  view().set_recording(true);
  const QImage recorded = picture();
  EXPECT_TRUE(differ_at(with, recorded, cube(), 20));
  view().set_recording(false);
  EXPECT_FALSE(differ_at(with, recorded, place_of(kFront)));
  press_key(Qt::Key_P);
  // The oblique view sees most of the face +z; the +x face is at its right.
  click_at(cube() + QPoint(-6, 6));
  EXPECT_EQ(place_of(Vector3(0.6, 0.15, 0.0)), place_of(Vector3(0.6, 0.15, 0.3)));
  EXPECT_GT(place_of(Vector3(1.2, 0.0, 0.0)).x(), place_of(Vector3(0.0, 0.0, 0.0)).x());
  keep_picture("cube");
  press_key(Qt::Key_O);
  wait(50);
  click_at(cube() + QPoint(26, 4));
  EXPECT_EQ(place_of(Vector3(0.0, 0.15, 0.15)), place_of(Vector3(1.2, 0.15, 0.15)));
  click("cube");
  EXPECT_FALSE(view().drawing().cube);
}

TEST_F(Picture, DisplacementsAreDrawnLargerAndStillPicked) {
  // The run stops at its end: a beam that falls further turns its corner away from the eye.
  Document document = falling_beam();
  document.scene.time.end = 0.1;
  show(std::move(document));
  raise("dock_drawing");
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().time > 0.1 - 1e-9; }));
  settle();
  const Index tip = nearest({1.2, 0.3, 0.3});
  const Vector3 rest = window_->simulation()->mesh().vertices[tip];
  const Vector3 there = position(tip);
  ASSERT_GT((there - rest).norm(), 0.005);
  type(find<NumberField>("displacement_scale"), "4");
  wait();
  press_key(Qt::Key_Home);
  wait();
  EXPECT_EQ(view().drawing().displacement_scale, 4.0);
  // A slow renderer shows the state of the end later.
  EXPECT_TRUE(wait_for(
      [&] { return view().vertex_at(place_of(Vector3(rest + 4.0 * (there - rest)))) == tip; },
      20000));
  keep_picture("displacement_scale");
  // The state itself is the same.
  EXPECT_EQ(vertex_block(view().state()->position, tip), there);
  type(find<NumberField>("displacement_scale"), "-1");
  EXPECT_EQ(view().drawing().displacement_scale, 4.0);
}

TEST_F(Picture, MinimumAndMaximumAndAGhostAreMarked) {
  show(falling_beam());
  raise("dock_drawing");
  run_to(0.05);
  press_key(Qt::Key_G);
  run_to(0.15);
  const QImage plain = picture();
  click("extremes");
  const QImage marked = picture();
  keep_picture("extremes");
  EXPECT_GT(differing_pixels(plain, marked), 100);
  click("extremes");
  EXPECT_EQ(differing_pixels(plain, picture()), 0);
  click("ghost");
  const auto pink = [](QRgb c) { return qRed(c) > qGreen(c) + 40 && qBlue(c) > qGreen(c) + 15; };
  EXPECT_GT(pixels(picture(), pink).size(), pixels(plain, pink).size() + 100);
  keep_picture("ghost");
}

TEST_F(Picture, SmoothAveragedAndTransparentSurfaces) {
  show(falling_beam());
  raise("dock_drawing");
  run_to(0.15);
  click("edges");
  QImage before = picture();
  for (const char* name : {"averaged", "smooth"}) {
    click(name);
    const QImage after = picture();
    EXPECT_GT(differing_pixels(before, after), 300) << name;
    keep_picture(name);
    before = after;
  }
  // A rest shape inside a translucent body is seen.
  press_key_in("opacity", Qt::Key_Home);
  EXPECT_NEAR(view().drawing().opacity, 0.1, 1e-9);
  EXPECT_GT(brightness(picture(), place_of(position(nearest(kTop)))),
            brightness(before, place_of(position(nearest(kTop)))));
  keep_picture("opacity");
}

TEST_F(Picture, ABandTakesVisibleVerticesAndWithAltAll) {
  show_beam();
  trigger("tool_2");
  const QSize size = view().canvas()->size();
  const QPoint from(8, size.height() / 8);
  const QPoint to(size.width() - 130, size.height() - 8);
  drag(from, to);
  const auto has = [this](const Vector3& point) {
    return std::ranges::count(window_->selection(), nearest(point)) > 0;
  };
  EXPECT_TRUE(has({1.2, 0.3, 0.3}) && has({0.6, 0.15, 0.3}) && has({0.6, 0.3, 0.0}));
  EXPECT_FALSE(has({0.6, 0.15, 0.15})) << "it is inside";
  EXPECT_FALSE(has({0.6, 0.0, 0.0}) || has({0.3, 0.15, 0.0})) << "they are behind";
  drag(from, to, Qt::AltModifier);
  EXPECT_EQ(window_->selection().size(), 81U);
}

TEST_F(Picture, AFaceIsSelectedUpToItsEdges) {
  show_beam();
  click_at(place_of(kFront), Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_EQ(window_->selection().size(), 27U);
  for (const Index v : window_->selection()) EXPECT_NEAR(position(v).z(), 0.3, 1e-9);
  click_at(place_of(kTop), Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_EQ(window_->selection().size(), 45U) << "another face is added";
  press_key_in("face_angle", Qt::Key_End);
  EXPECT_EQ(view().drawing().face_angle, 90.0);
}

TEST_F(Picture, GroupsOfTheFileAreSelected) {
  Document document = quiet_beam();
  document.mesh.groups.push_back({"Bolts & nuts", 0, 3, {2, 5, 7}, {}});
  show(std::move(document));
  auto* menu = find<QMenu>("groups");
  emit menu->aboutToShow();
  ASSERT_EQ(menu->actions().size(), 1);
  EXPECT_EQ(menu->actions()[0]->text(), QStringLiteral("Bolts && nuts"));
  menu->actions()[0]->trigger();
  EXPECT_EQ(window_->selection(), (std::vector<Index>{2, 5, 7}));
}

TEST_F(Picture, DistancesAndAnglesAreMeasured) {
  show_beam();
  auto* text = find<QLabel>("measure");
  window_->select({nearest({0.0, 0.0, 0.3}), nearest({1.2, 0.0, 0.3})});
  EXPECT_TRUE(wait_for([&] { return text->text().endsWith(QStringLiteral(": 1.2 m")); }, 3000))
      << text->text().toStdString();
  window_->select({nearest({0.0, 0.0, 0.3}), nearest({0.3, 0.0, 0.3}), nearest({0.0, 0.3, 0.3})});
  EXPECT_TRUE(wait_for([&] { return text->text().contains(QStringLiteral("90.00°")); }, 3000));
  window_->select({});
  EXPECT_TRUE(wait_for([&] { return text->text().isEmpty(); }, 3000));
}

}  // namespace
}  // namespace tetraction::viewer
