// Running, pausing, stepping; time steps, integrator, solver; what the window says when it goes wrong.
#include <QComboBox>
#include <QLabel>
#include <QMessageBox>
#include <QPushButton>

#include "dialogs.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

using Controls = WindowTest;

TEST_F(Controls, FirstSceneMoves) {
  show(first_scene());
  window_->simulation()->run();
  const Vector start = state().position;
  EXPECT_TRUE(wait_for([&] { return state().time > 0.3; }));
  EXPECT_GT((state().position - start).norm(), 1e-3);
  window_->simulation()->pause();
  keep_picture("first_scene");
}

TEST_F(Controls, SpaceRunsAndPauses) {
  show(quiet_beam());
  EXPECT_FALSE(state().running);
  press_key(Qt::Key_Space);
  EXPECT_TRUE(wait_for([&] { return state().running && state().step > 2; }));
  press_and_settle(Qt::Key_Space);
  EXPECT_FALSE(state().running);
  const Index step = state().step;
  wait(200);
  EXPECT_EQ(state().step, step);
}

TEST_F(Controls, StepAndRestartByKeyAndButton) {
  show(quiet_beam());
  press_and_settle(Qt::Key_S);
  EXPECT_EQ(state().step, 1);
  push("bar_step");
  EXPECT_EQ(state().step, 2);
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(state().step, 0);
  QTest::mouseClick(find<QAbstractButton>("bar_run"), Qt::LeftButton);
  EXPECT_TRUE(wait_for([&] { return state().step > 1; }));
  push("bar_restart");
  EXPECT_EQ(state().step, 0);
  EXPECT_FALSE(state().running);
}

TEST_F(Controls, StepSizeIntegratorAndSolver) {
  show(quiet_beam());
  show_entry("time");
  enter("step", "0.002");
  EXPECT_EQ(window_->simulation()->settings().time.step, 0.002);

  auto* integrator = find<QComboBox>("integrator");
  integrator->setFocus();
  QTest::keyClick(integrator, Qt::Key_Home);  // explicit
  settle();
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kExplicit);

  find<QComboBox>("integrator")->setFocus();
  QTest::keyClick(find<QComboBox>("integrator"), Qt::Key_End);  // energy-momentum
  settle();
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kEnergyMomentum);

  QTest::keyClick(find<QComboBox>("integrator"), Qt::Key_Up);  // backward-euler
  settle();
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kBackwardEuler);
  show_entry("solver");
  enter("tolerance", "1e-6");
  auto* solver = find<QComboBox>("kind");
  solver->setFocus();
  QTest::keyClick(solver, Qt::Key_End);  // Ceres
  settle();
  EXPECT_EQ(window_->simulation()->settings().solver.kind, "ceres");
  EXPECT_EQ(window_->simulation()->settings().solver.tolerance, 1e-6);
}

TEST_F(Controls, AdaptiveStepsAndRetries) {
  show(quiet_beam());
  make_edit(SetTime{{Integrator::kMidpoint, 0.002, false, 1000.0}}, "Midpoint");
  const auto time = [this] { return window_->simulation()->settings().time; };
  show_entry("time");
  const auto has_field = [this](const char* name) {
    return window_->findChild<NumberField*>(QLatin1String(name)) != nullptr;
  };
  EXPECT_FALSE(has_field("tolerance"));
  enter("retry", "1");
  EXPECT_EQ(time().retry, 1);

  auto* adapt = find<QComboBox>("adapt");
  adapt->setFocus();
  QTest::keyClick(adapt, Qt::Key_Down);  // error
  settle();
  EXPECT_EQ(time().adapt, StepAdaptation::kError);
  EXPECT_EQ(time().retry, 0);
  EXPECT_EQ(number_field("retry")->value(), 0);
  enter("tolerance", "1e-5");
  EXPECT_EQ(time().tolerance, 1e-5);
  keep_picture("adaptive");

  adapt = find<QComboBox>("adapt");
  adapt->setFocus();
  QTest::keyClick(adapt, Qt::Key_End);  // energy, which an explicit rule cannot keep in this way
  settle();
  EXPECT_EQ(time().adapt, StepAdaptation::kEnergy);
  auto* integrator = find<QComboBox>("integrator");
  integrator->setFocus();
  QTest::keyClick(integrator, Qt::Key_Home);
  settle();
  EXPECT_TRUE(reason("integrator").contains(QStringLiteral("implicit rules")));
  EXPECT_EQ(time().integrator, Integrator::kMidpoint);
}

TEST_F(Controls, NumbersOutOfRangeAreRefusedWithTheRange) {
  show(quiet_beam());
  show_entry("time");
  NumberField* field = number_field("step");
  const double before = field->value();
  type(field, "-3");
  wait(400);
  EXPECT_TRUE(reason("step").contains(QStringLiteral("above 0")));
  EXPECT_EQ(field->text(), QStringLiteral("-3")) << "it stays until it is corrected";
  keep_picture("refused");
  EXPECT_EQ(field->value(), before);
  QTest::keyClick(field, Qt::Key_Escape);
  EXPECT_EQ(field->text().toDouble(), before);
  settle();
  EXPECT_EQ(window_->simulation()->settings().time.step, before);
}

TEST_F(Controls, LimitTurnsRedAndBlowUpOffersTheWayBack) {
  show(falling_beam());
  const double limit = state().stable_step;
  ASSERT_GT(limit, 0.0);
  make_edit(SetTime{{Integrator::kVerlet, 3.0 * limit, false, 1000.0}}, "Verlet");
  show_entry("time");
  wait(200);
  EXPECT_TRUE(find<QLabel>("limit")->styleSheet().contains(QStringLiteral("#b00000")));
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([this] { return way_back() != nullptr; }));
  keep_picture("blow_up");
  EXPECT_EQ(state().status, RunStatus::kUnstable);
  EXPECT_FALSE(window_->messages()->text().isEmpty());
  QTest::mouseClick(way_back(), Qt::LeftButton);
  settle();
  EXPECT_EQ(state().status, RunStatus::kRunning);
  EXPECT_FALSE(state().running);
  EXPECT_EQ(way_back(), nullptr);
}

// The message suggests a smaller step: what sets one goes back by itself, and nothing that is said
// meanwhile takes the button for the way back away.
TEST_F(Controls, AfterAFailureEverythingLeadsBack) {
  show(falling_beam());
  QAction* menu = menu_action(QStringLiteral("&Back to the last good state"));
  EXPECT_FALSE(menu->isEnabled());
  const double limit = state().stable_step;
  const auto blow_up = [&] {
    window_->simulation()->edit(SetTime{{Integrator::kVerlet, 3.0 * limit, false, 1000.0}},
                                "large");
    window_->simulation()->set_speed_limit(0.0);
    window_->simulation()->run();
    ASSERT_TRUE(wait_for([&] { return way_back() != nullptr; }));
    ASSERT_EQ(state().status, RunStatus::kUnstable);
    settle();
  };
  blow_up();
  // Running on and kicking a vertex are refused, and the reason and the button stay.
  EXPECT_FALSE(window_->messages()->text().isEmpty());
  press_and_settle(Qt::Key_Space);
  EXPECT_NE(way_back(), nullptr);
  // The warning about the step gives way to the reason of the failure.
  const QString failure = QStringLiteral("the energy blew up");
  expect_told(failure);
  expect_told(QStringLiteral("go back to the last good"));
  make_edit(SetMomentum{}, "kick");
  EXPECT_NE(way_back(), nullptr);
  expect_told(failure);
  // The message is closed: the menu and the key are left.
  window_->messages()->clear();
  EXPECT_TRUE(menu->isEnabled());
  press_and_settle(Qt::Key_B);
  EXPECT_EQ(state().status, RunStatus::kRunning);
  EXPECT_FALSE(menu->isEnabled());

  blow_up();
  show_entry("time");
  push("use_half");
  EXPECT_EQ(state().status, RunStatus::kRunning);
  EXPECT_LT(window_->simulation()->settings().time.step, limit);
  EXPECT_FALSE(window_->messages()->isVisible());
  EXPECT_FALSE(menu->isEnabled());
  const Index step = state().step;
  press_key(Qt::Key_Space);
  ASSERT_TRUE(wait_for([&] { return state().step > step + 5; }));
  press_and_settle(Qt::Key_Space);
  EXPECT_EQ(state().status, RunStatus::kRunning);

  blow_up();
  press_key(Qt::Key_Z, Qt::ControlModifier);  // the step that was too large
  settle();
  EXPECT_EQ(state().status, RunStatus::kRunning);
  EXPECT_LT(window_->simulation()->settings().time.step, limit);
  EXPECT_FALSE(window_->messages()->isVisible());
}

TEST_F(Controls, RestartKeepsAndReloadAsks) {
  show(quiet_beam());
  const auto viscosity = [this] { return window_->simulation()->settings().damping.viscosity; };
  const double before = viscosity();
  // Nothing to lose: nothing is asked.
  press_and_settle(Qt::Key_S);
  press_and_settle(Qt::Key_R, Qt::ControlModifier);
  EXPECT_EQ(state().step, 0);
  show_entry("damping");
  enter("viscosity", "20");
  press_and_settle(Qt::Key_S);
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(state().step, 0);
  EXPECT_EQ(viscosity(), 20.0);
  EXPECT_EQ(find<NumberSlider>("viscosity")->value(), 20.0);
  press_and_settle(Qt::Key_S);
  {
    const DialogAnswer answer([](QDialog& dialog) { dialog.reject(); });
    menu_action(QStringLiteral("Re&load"))->trigger();
    EXPECT_TRUE(answer.given());
    EXPECT_FALSE(answer.stuck());
  }
  settle();
  EXPECT_EQ(state().step, 1);
  EXPECT_EQ(viscosity(), 20.0);
  {
    QString text;
    const DialogAnswer answer([&](QDialog& dialog) {
      auto* box = qobject_cast<QMessageBox*>(&dialog);
      if (box == nullptr) return;
      text = box->text();
      box->button(QMessageBox::Discard)->click();
    });
    menu_action(QStringLiteral("Re&load"))->trigger();
    EXPECT_TRUE(answer.given());
    EXPECT_TRUE(text.contains(QStringLiteral("Restart"))) << text.toStdString();
  }
  settle();
  EXPECT_EQ(state().step, 0);
  EXPECT_EQ(viscosity(), before);
}

TEST_F(Controls, UndoAndRedoWithTheirTexts) {
  show(quiet_beam());
  make_edit(SetDamping{{0.0, 2.0, 0.0}}, "Mass damping 2 1/s");
  const auto action = [&](const QString& beginning) -> QAction* {
    for (QAction* candidate : window_->findChildren<QAction*>()) {
      if (candidate->text().startsWith(beginning)) return candidate;
    }
    return nullptr;
  };
  QAction* undo = action(QStringLiteral("&Undo"));
  ASSERT_NE(undo, nullptr);
  EXPECT_TRUE(undo->text().contains(QStringLiteral("Mass damping 2 1/s")));
  undo->trigger();
  settle();
  EXPECT_EQ(window_->simulation()->settings().damping.mass_damping, 0.0);
  QAction* redo = action(QStringLiteral("&Redo"));
  ASSERT_NE(redo, nullptr);
  redo->trigger();
  settle();
  EXPECT_EQ(window_->simulation()->settings().damping.mass_damping, 2.0);
}

}  // namespace
}  // namespace tetraction::viewer
