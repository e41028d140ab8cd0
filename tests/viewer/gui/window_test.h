// A window on a scene, driven as a person drives it.
#pragma once

#include <gtest/gtest.h>

#include <QAbstractButton>
#include <QAction>
#include <QApplication>
#include <QDir>
#include <QDockWidget>
#include <QLabel>
#include <QPushButton>
#include <QSettings>
#include <QStatusBar>
#include <QtTest/QTest>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "support/scene_parts.h"
#include "tetraction/core/blas.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/widgets/number_field.h"
#include "viewer/gui/window/documents.h"
#include "viewer/gui/window/main_window.h"

namespace tetraction::viewer {

using namespace tetraction::testing_support;

/// A clamped beam without gravity, at rest: what happens to it is what the test does.
inline Document quiet_beam() {
  Document document = first_scene();
  document.scene.environment.kind = EnvironmentKind::kNone;
  document.scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {1.2, 0.3, 0.3}, {8, 2, 2}};
  document.mesh = mesh_of(document.scene);
  return document;
}

/// The same beam, falling and without damping.
inline Document falling_beam() {
  Document document = quiet_beam();
  document.scene.environment.kind = EnvironmentKind::kGravity;
  document.scene.damping = {};
  return document;
}

class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    QSettings().clear();
    open_window();
  }
  /// Another window; as large as it was when the one before was closed, or of the usual size.
  void open_window(bool usual_size = true) {
    window_ = std::make_unique<MainWindow>();
    if (usual_size) window_->resize(1280, 800);
    window_->show();
    QApplication::setActiveWindow(
        window_.get());  // no window manager does it, and shortcuts need it
    ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get(), 30000));
  }

  void open(const QString& path) {
    window_->open(path);
    wait_until_opened();
  }
  void wait_until_opened() {
    ASSERT_TRUE(wait_for([this] { return !window_->opening(); }));
  }
  void show(Document document) {
    window_->show_document(std::move(document));
    wait();
  }
  /// The beam at rest, with the panel of what is drawn.
  void show_beam() {
    show(quiet_beam());
    raise("dock_drawing");
  }
  QImage picture() {
    wait(50);
    return window_->body_view()->picture();
  }
  /// Lets the window work for a moment.
  static void wait(int ms = 100) { QTest::qWait(ms); }
  /// Waits for the simulation, then for the window to show what it did.
  void settle() {
    wait(80);  // a slider waits for half of that before it makes its edit
    ASSERT_TRUE(window_->simulation()->wait_until_idle(20.0));
    constexpr int kLongest_ms = 400;
    const auto is_shown = [this] {
      const auto& shown = window_->body_view()->state();
      return shown && shown->generation == state().generation;
    };
    wait_for(is_shown, kLongest_ms);
    // After a picture the next update of the charts, fields and menus writes the rate of the pictures.
    QLabel* rate = picture_rate();
    rate->clear();
    window_->body_view()->render();
    wait_for([rate] { return !rate->text().isEmpty(); }, kLongest_ms);
  }
  /// The label of the pictures that are drawn in a second.
  QLabel* picture_rate() {
    for (QLabel* label : window_->statusBar()->findChildren<QLabel*>()) {
      if (label->toolTip() == QStringLiteral("Pictures drawn in a second")) return label;
    }
    throw std::runtime_error("the status bar has no rate of pictures");
  }
  /// The same while it runs on: for the next pictures.
  void settle_running() {
    const Index step = state().step;
    ASSERT_TRUE(wait_for([&] { return state().step > step + 3; }));
    wait(300);
  }
  // A busy machine and sanitizers take their time.
  static bool wait_for(const std::function<bool()>& done, int ms = 120000) {
    return QTest::qWaitFor(done, ms);
  }
  /// As fast as it goes, to this time or a little later.
  void run_to(double time) {
    window_->simulation()->set_speed_limit(0.0);
    window_->simulation()->run();
    ASSERT_TRUE(wait_for([&] { return state().time > time; }));
    window_->simulation()->pause();
    settle();
  }

  template <class Widget>
  Widget* find(const char* name) {
    Widget* widget = window_->findChild<Widget*>(QLatin1String(name));
    EXPECT_NE(widget, nullptr) << name;
    return widget;
  }
  void trigger(const char* name) {
    auto* action = window_->findChild<QAction*>(QLatin1String(name));
    ASSERT_NE(action, nullptr) << name;
    action->trigger();
  }
  /// Of a menu, by the beginning of its text.
  QAction* menu_action(const QString& beginning) {
    for (QAction* action : window_->findChildren<QAction*>()) {
      if (action->text().startsWith(beginning)) return action;
    }
    ADD_FAILURE() << "no action " << beginning.toStdString();
    return nullptr;
  }
  /// Shows an entry of the scene in the inspector.
  void show_entry(const std::string& section, std::size_t index = 0) {
    const SceneTree* tree = window_->scene_panels()->tree();
    const EntryPlace place{section, index};
    ASSERT_TRUE(wait_for([&] { return tree->item_of(place) != nullptr; }, 5000)) << section;
    raise("dock_inspector");
    window_->scene_panels()->choose(place);
    wait(50);
  }
  /// Types a number in the inspector and waits for what it does. The field may be a part of a slider or a vector.
  void enter(const char* name, const char* text, int component = 0) {
    enter(number_field(name, component), text);
  }
  NumberField* number_field(const char* name, int component = 0) {
    auto* widget = find<QDockWidget>("dock_inspector")->findChild<QWidget*>(QLatin1String(name));
    if (widget == nullptr) throw std::runtime_error(std::string("no field ") + name);
    if (auto* field = qobject_cast<NumberField*>(widget)) return field;
    return widget->findChildren<NumberField*>().at(component);
  }
  /// The reason below a field of the inspector; empty if there is none.
  QString reason(const std::string& name) {
    auto* label = find<QLabel>(("reason_" + name).c_str());
    return label->isVisible() ? label->text() : QString();
  }
  void raise(const char* dock) {
    find<QDockWidget>(dock)->raise();
    wait(50);
  }
  /// A check box, a button: at its left end, as a check box is wider than what can be clicked.
  void click(const char* name) {
    auto* widget = find<QWidget>(name);
    QTest::mouseClick(widget, Qt::LeftButton, Qt::NoModifier, QPoint(8, widget->height() / 2));
  }
  /// A key for a combo box or a slider that was reached with Tab.
  void press_key_in(const char* name, int key) {
    auto* widget = find<QWidget>(name);
    widget->setFocus(Qt::TabFocusReason);
    QTest::keyClick(widget, static_cast<Qt::Key>(key));
  }
  /// Types a number and Return.
  static void type(NumberField* field, const char* text) {
    field->setFocus();
    field->selectAll();
    QTest::keyClicks(field, QLatin1String(text));
    QTest::keyClick(field, Qt::Key_Return);
  }
  /// The same, and waits for what it does.
  void enter(NumberField* field, const char* text) {
    type(field, text);
    settle();
  }
  void press_and_settle(int key, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    press_key(key, modifiers);
    settle();
  }
  /// A button, and waits for what it does.
  void push(const char* name) {
    QTest::mouseClick(find<QAbstractButton>(name), Qt::LeftButton);
    settle();
  }
  void make_edit(const Edit& edit, const std::string& description) {
    window_->simulation()->edit(edit, description);
    settle();
  }
  void press_key(int key, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    // Without a window manager nobody activates the window again after a dialog was closed. Shortcuts need
    // an active window.
    if (!window_->isActiveWindow()) {
      window_->activateWindow();
      EXPECT_TRUE(QTest::qWaitForWindowActive(&*window_, 30000));
    }
    QTest::keyClick(window_->body_view()->canvas(), static_cast<Qt::Key>(key), modifiers);
  }

  /// That the window tells a text with this part.
  void expect_told(const QString& part) const {
    const QString text = window_->messages()->text();
    EXPECT_TRUE(text.contains(part)) << text.toStdString();
  }
  /// What the window tells; empty also for what a machine's BLAS is warned of, which is no matter here.
  QString message() const {
    QStringList lines = window_->messages()->text().split(QLatin1Char('\n'));
    lines.removeAll(QString::fromStdString(blas_warning()));
    return lines.join(QLatin1Char('\n'));
  }

  /// The button of a message by its text, if the message is there.
  QPushButton* action_button(const QString& text) const {
    for (QPushButton* button : window_->messages()->findChildren<QPushButton*>()) {
      if (button->text().startsWith(text) && button->isVisible()) return button;
    }
    return nullptr;
  }
  QPushButton* way_back() const {
    return action_button(QStringLiteral("Back to the last good state"));
  }
  /// Presses such a button and waits for what it does.
  void answer(const QString& text) {
    QPushButton* button = action_button(text);
    ASSERT_NE(button, nullptr) << text.toStdString();
    QTest::mouseClick(button, Qt::LeftButton);
    settle();
  }

  const Snapshot& state() {
    snapshot_ = window_->simulation()->peek();
    return *snapshot_;
  }
  Vector3 position(Index vertex) { return vertex_block(state().position, vertex); }
  QPoint place_of(Index vertex) {
    return window_->body_view()->to_canvas(position(vertex)).toPoint();
  }
  QPoint place_of(const Vector3& point) { return window_->body_view()->to_canvas(point).toPoint(); }
  /// The surface vertex nearest to a point.
  Index nearest(const Vector3& point) {
    const TetMesh& mesh = window_->simulation()->mesh();
    Index best = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const auto at = [&](Index i) {
        return (mesh.vertices[static_cast<std::size_t>(i)] - point).norm();
      };
      if (at(v) < at(best)) best = v;
    }
    return best;
  }
  /// With the left button, on the body's picture or another canvas.
  void drag(const QPoint& from, const QPoint& to,
            Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    drag(window_->body_view()->canvas(), from, to, modifiers);
  }
  void drag(QWidget* canvas, const QPoint& from, const QPoint& to,
            Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    QTest::mousePress(canvas, Qt::LeftButton, modifiers, from);
    constexpr int kMoves = 8;
    for (int i = 1; i <= kMoves; ++i) {
      QTest::mouseMove(canvas, from + (to - from) * i / kMoves);
      wait(30);
    }
    while_pressed_();
    QTest::mouseRelease(canvas, Qt::LeftButton, modifiers, to);
    wait(50);
  }
  /// Keeps a picture of the window for people to look at.
  void keep_picture(const char* name) {
    wait(300);
    QDir().mkpath(QStringLiteral(TETRACTION_SCREENSHOTS));
    EXPECT_TRUE(window_->grab().save(
        QStringLiteral(TETRACTION_SCREENSHOTS "/%1.png").arg(QLatin1String(name))));
  }

  std::unique_ptr<MainWindow> window_;
  std::shared_ptr<const Snapshot> snapshot_;
  std::function<void()> while_pressed_ = [] {};
};

}  // namespace tetraction::viewer
