// Everything without a mouse: Tab, shortcuts.
#include <QAbstractButton>
#include <QAbstractSlider>
#include <QAbstractSpinBox>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QScrollBar>
#include <QSet>
#include <QSpinBox>
#include <QTabBar>

#include "dialogs.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Keyboard : public WindowTest {
 protected:
  // What takes input in a panel that is seen.
  static QList<QWidget*> inputs(const QWidget* panel) {
    QList<QWidget*> found;
    for (QWidget* widget : panel->findChildren<QWidget*>()) {
      const bool input = qobject_cast<QAbstractButton*>(widget) != nullptr ||
                         qobject_cast<QAbstractSlider*>(widget) != nullptr ||
                         qobject_cast<QComboBox*>(widget) != nullptr ||
                         qobject_cast<QAbstractSpinBox*>(widget) != nullptr ||
                         qobject_cast<QLineEdit*>(widget) != nullptr ||
                         qobject_cast<QTabBar*>(widget) != nullptr;
      // A spin box has its line's focus; what a bar scrolls is scrolled to by Tab itself; the buttons
      // that scroll a row of tabs are Qt's own.
      const bool part = qobject_cast<QAbstractSpinBox*>(widget->parentWidget()) != nullptr ||
                        qobject_cast<QTabBar*>(widget->parentWidget()) != nullptr ||
                        qobject_cast<QScrollBar*>(widget) != nullptr;
      if (input && !part && widget->isVisible() && widget->isEnabled()) found.push_back(widget);
    }
    return found;
  }
  static std::string name_of(const QWidget* widget) {
    return (QLatin1String(widget->metaObject()->className()) + QLatin1String(" ") +
            widget->objectName() + QLatin1String(" ") + widget->toolTip())
        .toStdString();
  }
  // All that has the focus in turn as the key is pressed, until it comes round.
  QSet<QWidget*> round(QWidget* start, Qt::Key key) {
    QSet<QWidget*> reached;
    start->setFocus(Qt::TabFocusReason);
    constexpr int kMost = 300;
    for (int i = 0; i < kMost; ++i) {
      QWidget* now = QApplication::focusWidget();
      if (now == nullptr || (now == start && i > 0)) break;
      reached.insert(now);
      QTest::keyClick(now, key);
      EXPECT_NE(QApplication::focusWidget(), now) << "the key leaves it not: " << name_of(now);
      if (QApplication::focusWidget() == now) break;
    }
    EXPECT_EQ(QApplication::focusWidget(), start) << "it comes not round";
    return reached;
  }
};

TEST_F(Keyboard, TabReachesEveryControl) {
  Document document = quiet_beam();
  document.scene.material.model = "mooney-rivlin";
  document.scene.material.numbers["ratio"] = 0.5;
  show(std::move(document));
  window_->select({nearest({0.0, 0.3, 0.3})});  // it is held: everything can be done with it
  settle();
  QWidget* charts = find<QDockWidget>("dock_charts")->widget();
  for (const char* name : {"transport", "material", "damping", "time", "fix", "mesh",
                           "dock_vertices", "dock_drawing"}) {
    const bool is_dock = QLatin1String(name).startsWith(QLatin1String("dock"));
    const bool is_bar = QLatin1String(name) == QLatin1String("transport");
    if (is_dock) {
      raise(name);
    } else if (!is_bar) {
      show_entry(name);
    }
    const QList<QWidget*> there =
        inputs(is_bar ? find<QWidget>(name)
                      : find<QDockWidget>(is_dock ? name : "dock_inspector")->widget());
    ASSERT_GE(there.size(), 4) << name;
    for (const Qt::Key key : {Qt::Key_Tab, Qt::Key_Backtab}) {
      const QSet<QWidget*> reached = round(there.front(), key);
      for (QWidget* widget : there + inputs(charts)) {
        EXPECT_TRUE(reached.contains(widget)) << name << ": " << name_of(widget);
      }
      EXPECT_TRUE(reached.contains(window_->body_view()->canvas()));
    }
  }
}

TEST_F(Keyboard, DigitsChooseTools) {
  show(quiet_beam());
  const std::pair<int, Tool> tools[] = {{Qt::Key_2, Tool::kSelect},
                                        {Qt::Key_3, Tool::kMove},
                                        {Qt::Key_4, Tool::kForce},
                                        {Qt::Key_5, Tool::kMomentum},
                                        {Qt::Key_1, Tool::kLook}};
  for (const auto& [key, tool] : tools) {
    press_key(key);
    EXPECT_EQ(window_->body_view()->tool(), tool);
    for (int i = 1; i <= 5; ++i) {
      auto* action = find<QAction>(QByteArray("tool_").append(QByteArray::number(i)).constData());
      EXPECT_EQ(action->isChecked(), i == key - Qt::Key_0);
    }
  }
  // From a button, too; in a field they are digits.
  press_key_in("bar_run", Qt::Key_3);
  EXPECT_EQ(window_->body_view()->tool(), Tool::kMove);
  show_entry("time");
  NumberField* field = number_field("step");
  field->setFocus();
  field->selectAll();
  QTest::keyClick(field, Qt::Key_5);
  EXPECT_EQ(field->text(), QStringLiteral("5"));
  EXPECT_EQ(window_->body_view()->tool(), Tool::kMove);
}

// After a number the keys are the body's again.
TEST_F(Keyboard, ANumberThatWasEnteredGivesTheKeyboardBack) {
  show(quiet_beam());
  show_entry("material");
  NumberField* field = number_field("youngs_modulus");
  QWidget* canvas = window_->body_view()->canvas();
  const auto press = [](int key) {
    QTest::keyClick(QApplication::focusWidget(), static_cast<Qt::Key>(key));
  };
  enter(field, "2e6");
  EXPECT_EQ(QApplication::focusWidget(), canvas);
  press(Qt::Key_S);
  settle();
  EXPECT_EQ(state().step, 1);
  EXPECT_EQ(field->text(), QStringLiteral("2e+06"));
  // With Escape the old number stays.
  field->setFocus();
  field->selectAll();
  QTest::keyClicks(field, "7");
  press(Qt::Key_Escape);
  EXPECT_EQ(QApplication::focusWidget(), canvas);
  EXPECT_EQ(field->text(), QStringLiteral("2e+06"));
  // What is refused is to be corrected first.
  type(field, "-1");
  EXPECT_EQ(QApplication::focusWidget(), field);
  press(Qt::Key_Escape);
  press(Qt::Key_Space);
  EXPECT_TRUE(wait_for([&] { return state().running; }));
  press(Qt::Key_Space);
  settle();
  auto* steps = find<QSpinBox>("steps_per_picture");
  for (const int key : {Qt::Key_Return, Qt::Key_Escape}) {
    steps->setFocus();
    steps->selectAll();
    QTest::keyClicks(steps, "2");
    press(key);
    EXPECT_EQ(QApplication::focusWidget(), canvas) << key;
    EXPECT_EQ(steps->value(), 2);
  }
}

TEST_F(Keyboard, AClickInThePictureTakesTheKeyboardAndKeepsIt) {
  show(quiet_beam());
  show_entry("fix");
  NumberField* field = number_field("at");
  type(field, "-x");
  EXPECT_EQ(QApplication::focusWidget(), field);
  QTest::keyClick(field, Qt::Key_Escape);
  // The fields are made anew, because there are selected vertices now that can be used.
  QWidget* canvas = window_->body_view()->canvas();
  QTest::mouseClick(canvas, Qt::LeftButton, Qt::NoModifier,
                    place_of(nearest(Vector3(1.2, 0.3, 0.3))));
  settle();
  EXPECT_FALSE(window_->selection().empty());
  EXPECT_TRUE(find<QAbstractButton>("use_selected")->isEnabled());
  EXPECT_EQ(QApplication::focusWidget(), canvas);
}

TEST_F(Keyboard, UndoAndRedo) {
  show(quiet_beam());
  show_entry("damping");
  const auto drag_now = [this] { return window_->simulation()->settings().damping.drag; };
  enter("drag", "0.25");
  enter("drag", "0.5");
  const auto press = [this](Qt::KeyboardModifiers modifiers) {
    press_and_settle(Qt::Key_Z, modifiers);
  };
  press(Qt::ControlModifier);
  EXPECT_EQ(drag_now(), 0.25);
  press(Qt::ControlModifier);
  EXPECT_EQ(drag_now(), 0.0);
  EXPECT_EQ(find<NumberSlider>("drag")->value(), 0.0);
  press(Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_EQ(drag_now(), 0.25);
  press(Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_EQ(drag_now(), 0.5);
  EXPECT_EQ(find<NumberSlider>("drag")->value(), 0.5);
}

TEST_F(Keyboard, F1ShowsTheKeys) {
  QString text;
  const DialogAnswer answer([&](QDialog& dialog) {
    if (const auto* box = qobject_cast<QMessageBox*>(&dialog)) text = box->text();
    QTest::keyClick(&dialog, Qt::Key_Escape);
  });
  press_key(Qt::Key_F1);
  EXPECT_TRUE(answer.given());
  EXPECT_FALSE(answer.stuck());
  for (const char* key : {"Space", "Ctrl+Z", "Home, O, X, Y, Z", "1 … 5"}) {
    EXPECT_TRUE(text.contains(QString::fromUtf8(key))) << key;
  }
  EXPECT_EQ(QApplication::activeModalWidget(), nullptr);
}

TEST_F(Keyboard, HomeAndLettersTurnTheCamera) {
  show(quiet_beam());
  const Vector3 middle(0.6, 0.15, 0.15);
  // Whether one looks along an axis: points on it through the middle are at one place.
  const auto along = [&](int axis) {
    const QPoint a = place_of(middle);
    const QPoint b = place_of(Vector3(middle + 0.1 * Vector3::Unit(axis)));
    return (a - b).manhattanLength() < 2;
  };
  const Vector3 tip(1.2, 0.3, 0.3);
  const QPoint home = place_of(tip);
  const int keys[] = {Qt::Key_X, Qt::Key_Y, Qt::Key_Z};
  for (int axis = 0; axis < 3; ++axis) {
    press_key(keys[axis]);
    for (int other = 0; other < 3; ++other) EXPECT_EQ(along(other), other == axis) << axis;
  }
  // Also after the mouse has turned it.
  drag(QPoint(200, 200), QPoint(260, 260));
  EXPECT_FALSE(along(2));
  press_key(Qt::Key_O);
  EXPECT_LT((place_of(tip) - home).manhattanLength(), 2);
}

// A body that has flown away is what the views show, not the place where it was.
TEST_F(Keyboard, ViewsFrameTheBodyWhereItIs) {
  Document document = quiet_beam();
  document.scene.fix.clear();
  document.scene.damping = {};
  document.scene.initial.velocity = {30.0, -50.0, 20.0};
  show(std::move(document));
  run_to(1.0);
  const QRect canvas = window_->body_view()->canvas()->rect();
  const Vector3 at_rest = window_->simulation()->mesh().vertices[0];
  ASSERT_GT((position(0) - at_rest).norm(), 50.0);
  ASSERT_FALSE(canvas.contains(place_of(Index{0})));
  for (const int key : {Qt::Key_Home, Qt::Key_X, Qt::Key_Y, Qt::Key_Z}) {
    press_key(key);
    QRect box;
    for (Index v = 0; v < window_->simulation()->mesh().vertex_count(); ++v) {
      EXPECT_TRUE(canvas.contains(place_of(v))) << key << " " << v;
      box |= QRect(place_of(v), QSize(1, 1));
    }
    EXPECT_GT(std::max(box.width(), box.height()), 50) << key;
  }
}

// In a field Ctrl+Z is about the text that is being typed.
TEST_F(Keyboard, CtrlZInAFieldUndoesTheText) {
  show(quiet_beam());
  show_entry("damping");
  enter("drag", "0.25");
  auto* field = find<NumberSlider>("viscosity")->field();
  const QString before = field->text();
  field->setFocus();
  field->selectAll();
  QTest::keyClicks(field, "7");
  for (int i = 0; i < 2; ++i) {
    QTest::keyClick(field, Qt::Key_Z, Qt::ControlModifier);
    settle();
    EXPECT_EQ(field->text(), before);
    EXPECT_EQ(window_->simulation()->settings().damping.drag, 0.25);
  }
}

}  // namespace
}  // namespace tetraction::viewer
