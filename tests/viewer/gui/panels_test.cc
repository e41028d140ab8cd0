// Panels of material, surroundings, vertices, drawing.
#include <QAbstractItemView>
#include <QCheckBox>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QMouseEvent>
#include <QPushButton>
#include <QScrollArea>
#include <cmath>

#include "viewer/gui/widgets/vector_fields.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Panels : public WindowTest {
 protected:
  void drag_number(NumberField* field, int pixels,
                   Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    window_->body_view()->canvas()->setFocus();
    const QPoint from = field->rect().center();
    const auto send = [&](QEvent::Type type, int by, Qt::MouseButton button) {
      const QPoint at = from + QPoint(by, 0);
      QMouseEvent event(type, at, field->mapToGlobal(at), button, Qt::LeftButton, modifiers);
      QCoreApplication::sendEvent(field, &event);
      wait(60);
    };
    send(QEvent::MouseButtonPress, 0, Qt::LeftButton);
    for (int i = 1; i <= 3; ++i) send(QEvent::MouseMove, 5 + (pixels - 5) * i / 3, Qt::NoButton);
    send(QEvent::MouseButtonRelease, pixels, Qt::LeftButton);
    settle();
  }
};

TEST_F(Panels, MaterialByNumberAndSlider) {
  show(quiet_beam());
  show_entry("material");
  enter("youngs_modulus", "2.5e5");
  const auto young = [this] {
    return window_->simulation()->settings().materials[0].youngs_modulus.value_or(0.0);
  };
  EXPECT_EQ(young(), 2.5e5);
  // A drag on the number: a decade in 60 pixels, with Shift in 600. It is one edit.
  drag_number(number_field("youngs_modulus"), 6);
  EXPECT_NEAR(young(), 2.5e5 * std::pow(10.0, 0.1), 0.01 * young());
  drag_number(number_field("youngs_modulus"), 6, Qt::ShiftModifier);
  EXPECT_NEAR(young(), 2.5e5 * std::pow(10.0, 0.11), 0.01 * young());
  window_->simulation()->undo();
  window_->simulation()->undo();
  settle();
  EXPECT_EQ(young(), 2.5e5);
  enter("poissons_ratio", "0.7");
  EXPECT_TRUE(reason("poissons_ratio").contains(QStringLiteral("0.5")));
  enter("poissons_ratio", "0.3");
  EXPECT_EQ(reason("poissons_ratio"), QString());
  EXPECT_EQ(window_->simulation()->settings().materials[0].poissons_ratio, 0.3);
  auto* model = find<QComboBox>("model");
  model->setFocus();
  QTest::keyClick(model, Qt::Key_End);
  settle();
  EXPECT_EQ(window_->simulation()->settings().materials[0].model, "gent");
  keep_picture("material");
}

// The parameter that an array gives cannot be typed, and the others can.
TEST_F(Panels, MaterialWithAnArray) {
  Document document = quiet_beam();
  document.mesh.cell_arrays["E"] =
      Vector::LinSpaced(document.mesh.tetrahedron_count(), 1e5, 5e5).transpose();
  document.scene.material.youngs_modulus.reset();
  document.scene.material.arrays["youngs_modulus"] = "E";
  show(std::move(document));
  show_entry("material");
  EXPECT_EQ(find<QLineEdit>("array")->text(), QStringLiteral("E"));
  EXPECT_EQ(window_->findChild<NumberField*>(QStringLiteral("youngs_modulus")), nullptr);
  enter("poissons_ratio", "0.2");
  auto settings = window_->simulation()->settings();
  EXPECT_EQ(settings.materials[0].poissons_ratio, 0.2);
  EXPECT_EQ(settings.materials[0].arrays.at("youngs_modulus"), "E");
  EXPECT_NEAR(settings.moduli[0].least.mu, 1e5 / 2.4, 1e-9);
  EXPECT_NEAR(settings.moduli[0].most.mu, 5e5 / 2.4, 1e-9);
  // The page is no wider than the dock: the range of the moduli is wrapped.
  auto* scroll = find<QDockWidget>("dock_inspector")->findChild<QScrollArea*>();
  ASSERT_NE(scroll, nullptr);
  EXPECT_LE(scroll->widget()->minimumSizeHint().width(), scroll->viewport()->width());
  auto* model = find<QComboBox>("model");
  model->setFocus();
  QTest::keyClick(model, Qt::Key_Home);
  settle();
  settings = window_->simulation()->settings();
  EXPECT_EQ(settings.materials[0].model, "stvk");
  EXPECT_EQ(settings.materials[0].arrays.at("youngs_modulus"), "E");
  keep_picture("material_array");
}

TEST_F(Panels, RegionsHaveMaterialsOfTheirOwn) {
  Document document = quiet_beam();
  const MaterialRegionSettings region{
      SelectBox{{0.6, 0.0, 0.0}, {1.2, 0.3, 0.3}}, document.scene.material, {}};
  document.scene.material_region.push_back(region);
  show(std::move(document));
  show_entry("material_region", 0);
  enter("youngs_modulus", "4e5");
  const auto materials = window_->simulation()->settings().materials;
  EXPECT_EQ(materials[0].youngs_modulus, 1.5e6);
  EXPECT_EQ(materials[1].youngs_modulus, 4e5);
  auto* field = find<QComboBox>("color_field");
  raise("dock_drawing");
  field->setFocus();
  QTest::keyClick(field, Qt::Key_End);
  settle();
  keep_picture("regions");
}

TEST_F(Panels, EnvironmentAndDamping) {
  show(quiet_beam());
  show_entry("environment");
  auto* kind = find<QComboBox>("kind");
  kind->setFocus();
  QTest::keyClick(kind, Qt::Key_Down);
  settle();
  EXPECT_EQ(window_->simulation()->settings().environment.kind, EnvironmentKind::kGravity);
  enter("strength", "1.62");
  EXPECT_EQ(window_->simulation()->settings().environment.strength, 1.62);
  show_entry("damping");
  enter("viscosity", "120");
  enter("drag", "-1");
  EXPECT_TRUE(reason("drag").contains(QStringLiteral("0 or more")));
  enter("drag", "0.25");
  enter("mass_damping", "3");
  const Damping damping = window_->simulation()->settings().damping;
  EXPECT_EQ(damping.viscosity, 120.0);
  EXPECT_EQ(damping.drag, 0.25);
  EXPECT_EQ(damping.mass_damping, 3.0);
  keep_picture("damping");
  show_entry("environment");
  kind = find<QComboBox>("kind");
  kind->setFocus();
  QTest::keyClick(kind, Qt::Key_Down);
  settle();
  EXPECT_EQ(window_->simulation()->settings().environment.kind, EnvironmentKind::kAttraction);
}

TEST_F(Panels, LoadsAreShownAndChanged) {
  Document document = quiet_beam();
  ForceSettings pressure = testing_support::pressure(SelectSurface{}, 200.0);
  pressure.amplitude = "late";
  document.scene.pressure = {pressure};
  document.scene.force = {total_load(SelectPlane{0, 1.2, {}}, {0.0, 3.0, 0.0})};
  document.scene.amplitude = {corners("late", {{1.0, 0.0}, {2.0, 1.0}})};
  document.scene.environment.kind = EnvironmentKind::kGravity;
  document.scene.environment.amplitude = "late";
  show(std::move(document));
  show_entry("environment");
  EXPECT_EQ(find<QComboBox>("amplitude")->currentText(), QStringLiteral("late"));
  show_entry("force", 0);
  EXPECT_EQ(number_field("total", 1)->value(), 3.0);
  enter("total", "5", 1);
  EXPECT_EQ(window_->simulation()->settings().loads.force.at(0).total, Vector3(0.0, 5.0, 0.0));
  EXPECT_NEAR(state().external_force.reshaped(3, state().external_force.size() / 3).row(1).sum(),
              5.0, 1e-12);
  show_entry("pressure", 0);
  EXPECT_EQ(number_field("value")->value(), 200.0);
  enter("value", "300");
  EXPECT_EQ(window_->simulation()->settings().loads.pressure.at(0).value, 300.0);
  EXPECT_EQ(window_->simulation()->settings().loads.pressure.at(0).amplitude, "late");
  keep_picture("loads");
  // A list stays open while the window shows new states, and another load in the tree before it
  // does not change what is chosen.
  auto* amplitude = find<QComboBox>("amplitude");
  amplitude->showPopup();
  wait(600);
  EXPECT_TRUE(amplitude->view()->isVisible());
  amplitude->view()->setCurrentIndex(amplitude->model()->index(0, 0));
  wait(600);
  EXPECT_EQ(amplitude->view()->currentIndex().row(), 0) << "not what the pointer is at";
  amplitude->hidePopup();
  ForceSettings another;
  another.select = SelectPlane{0, 0.0, {}};
  make_edit(SetForce{std::nullopt, another}, "another");
  EXPECT_EQ(window_->scene_panels()->tree()->chosen(), (EntryPlace{"pressure", 0}));
  EXPECT_EQ(number_field("value")->value(), 300.0);
  window_->simulation()->undo();
  window_->simulation()->undo();
  settle();
  EXPECT_EQ(window_->simulation()->settings().loads.pressure.at(0).value, 200.0);
  EXPECT_EQ(number_field("value")->value(), 200.0);
}

TEST_F(Panels, TypedPositionMomentumAndForce) {
  show(quiet_beam());
  raise("dock_vertices");
  const Index tip = nearest({1.2, 0.3, 0.3});
  window_->select({tip});
  wait(50);
  enter(find<NumberField>("force_x"), "5");
  EXPECT_DOUBLE_EQ(vertex_block(state().external_force, tip).x(), 5.0);
  enter(find<NumberField>("force_x"), "0");
  EXPECT_DOUBLE_EQ(vertex_block(state().external_force, tip).x(), 0.0);
  enter(find<NumberField>("momentum_x"), "0.25");
  EXPECT_DOUBLE_EQ(vertex_block(state().momentum, tip).x(), 0.25);
  enter(find<NumberField>("position_x"), "1.21");
  EXPECT_NEAR(position(tip).x(), 1.21, 1e-12);
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 0);
  push("place");
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 1);
  keep_picture("vertices");
  push("unfix");
  EXPECT_EQ(state().fixed[static_cast<std::size_t>(tip)], 0);
}

TEST_F(Panels, DrawingCombinations) {
  Document document = first_scene();
  document.scene.initial.angular_velocity = {0.0, 0.0, 0.5};
  show(std::move(document));
  raise("dock_drawing");
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().time > 0.15; }));
  window_->simulation()->pause();
  settle();
  for (const char* name : {"points", "momenta", "reactions", "rest", "axes"}) {
    auto* check = find<QCheckBox>(name);
    QTest::mouseClick(check, Qt::LeftButton, Qt::NoModifier, QPoint(8, check->height() / 2));
    EXPECT_TRUE(check->isChecked()) << name;
  }
  const DrawingSettings& drawing = window_->body_view()->drawing();
  EXPECT_TRUE(drawing.points && drawing.momenta && drawing.reactions && drawing.rest);
  keep_picture("drawing");
  auto* clip = find<QCheckBox>("clip");
  QTest::mouseClick(clip, Qt::LeftButton, Qt::NoModifier, QPoint(8, clip->height() / 2));
  EXPECT_TRUE(drawing.clip);
  keep_picture("clip");
  auto* field = find<QComboBox>("color_field");
  for (int i = 0; i < field->count(); ++i) {
    field->setFocus();
    QTest::keyClick(field, i == 0 ? Qt::Key_Home : Qt::Key_Down);
    settle();
    EXPECT_EQ(state().field, drawing.field);
  }
}

// The components are typed one after another, with Return or with Tab.
TEST_F(Panels, DirectionOfGravityIsEnteredAsOneVector) {
  Document document = quiet_beam();
  document.scene.environment.kind = EnvironmentKind::kGravity;
  show(std::move(document));
  show_entry("environment");
  settle();
  auto* fields = find<VectorFields>("direction");
  const auto direction = [this] { return window_->simulation()->settings().environment.direction; };
  const auto undo = [this] {
    window_->simulation()->undo();
    settle();
  };
  const char* const numbers[] = {"1", "2", "3"};
  for (int i = 0; i < 3; ++i) enter(fields->field(i), numbers[i]);
  EXPECT_LT((direction() - Vector3(1, 2, 3).normalized()).norm(), 1e-14);
  EXPECT_EQ(fields->value(), Vector3(1, 2, 3));
  for (int i = 0; i < 3; ++i) undo();
  EXPECT_EQ(direction(), Vector3(0, -1, 0));
  EXPECT_EQ(fields->value(), Vector3(0, -1, 0));
  // With Tab it is one edit, also if the components are zero for a while.
  fields->field(0)->setFocus();
  for (const char* number : {"0", "0", "-4"}) {
    EXPECT_EQ(direction(), Vector3(0, -1, 0));
    auto* field = qobject_cast<NumberField*>(QApplication::focusWidget());
    ASSERT_NE(field, nullptr);
    field->selectAll();
    QTest::keyClicks(field, QLatin1String(number));
    wait(300);  // the window shows the present settings meanwhile
    QTest::keyClick(field, Qt::Key_Tab);
  }
  settle();
  EXPECT_EQ(direction(), Vector3(0, 0, -1));
  undo();
  EXPECT_EQ(direction(), Vector3(0, -1, 0));
  // No direction at all.
  enter(fields->field(1), "0");
  EXPECT_TRUE(reason("direction").contains(QStringLiteral("must not be zero")));
  EXPECT_EQ(direction(), Vector3(0, -1, 0));
}

TEST_F(Panels, NumbersBeyondThoseOfTheComputerAreNamed) {
  Document document = quiet_beam();
  document.scene.environment.kind = EnvironmentKind::kGravity;
  show(std::move(document));
  show_entry("environment");
  auto* field = find<VectorFields>("direction")->field(0);
  for (const char* text : {"1e400", "-1e400", "+1e999"}) {
    type(field, text);
    const QString message = reason("direction");
    EXPECT_TRUE(message.contains(QStringLiteral("too large"))) << message.toStdString();
    EXPECT_FALSE(message.contains(QStringLiteral("any number"))) << message.toStdString();
  }
  type(field, "1e-400");
  EXPECT_TRUE(reason("direction").contains(QStringLiteral("too near to zero")));
  for (const char* text : {"abc", "nan", "1e"}) {
    type(field, text);
    EXPECT_TRUE(reason("direction").contains(QStringLiteral("any number"))) << text;
  }
  QTest::keyClick(field, Qt::Key_Escape);
}

// The fields show means of several vertices. Components that are not typed stay as they are.
TEST_F(Panels, SeveralVerticesKeepComponentsThatAreNotTyped) {
  show(quiet_beam());
  raise("dock_vertices");
  const Index a = nearest({1.2, 0.3, 0.3});
  const Index b = nearest({1.2, 0.0, 0.0});
  const auto momentum = [this](Index v) { return Vector3(vertex_block(state().momentum, v)); };
  const auto force = [this](Index v) { return Vector3(vertex_block(state().external_force, v)); };
  window_->select({a});
  wait(50);
  enter(find<NumberField>("momentum_x"), "0.5");
  enter(find<NumberField>("force_x"), "4");
  auto* y_force = qobject_cast<VectorFields*>(find<NumberField>("force_x")->parent())->field(1);
  auto* y_momentum =
      qobject_cast<VectorFields*>(find<NumberField>("momentum_x")->parent())->field(1);
  window_->select({a, b});
  wait(50);
  enter(y_momentum, "0.25");
  enter(y_force, "7");
  EXPECT_LT((momentum(a) - Vector3(0.5, 0.25, 0.0)).norm(), 1e-15);
  EXPECT_LT((momentum(b) - Vector3(0.0, 0.25, 0.0)).norm(), 1e-15);
  EXPECT_LT((force(a) - Vector3(4.0, 7.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((force(b) - Vector3(0.0, 7.0, 0.0)).norm(), 1e-15);
  const Vector3 distance = position(a) - position(b);
  const double y = position(a).y();
  enter(find<NumberField>("position_x"), "1.21");
  EXPECT_LT((position(a) - position(b) - distance).norm(), 1e-15);
  EXPECT_EQ(position(a).y(), y);
  EXPECT_NEAR(0.5 * (position(a) + position(b)).x(), 1.21, 1e-12);
}

}  // namespace
}  // namespace tetraction::viewer
