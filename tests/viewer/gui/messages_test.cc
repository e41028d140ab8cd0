// Messages belong to a cause, go with it, and leave the picture where it is.
#include <QComboBox>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Messages : public WindowTest {};

TEST_F(Messages, FloatOverThePictureAndLeaveItWhereItIs) {
  show(quiet_beam());
  settle();  // the first texts of the bars
  QWidget* canvas = window_->body_view()->canvas();
  const QRect before(canvas->mapTo(window_.get(), QPoint()), canvas->size());
  window_->select({nearest({1.2, 0.3, 0.3})});
  raise("dock_vertices");
  type(find<NumberField>("position_x"), "abc");
  wait();
  expect_told(QStringLiteral("abc"));
  EXPECT_EQ(QRect(canvas->mapTo(window_.get(), QPoint()), canvas->size()), before);
  EXPECT_LT(window_->messages()->height(), canvas->height() / 4);
  keep_picture("floating_message");
}

TEST_F(Messages, AWarningGoesWithTheUndoOfItsEdit) {
  show(quiet_beam());
  MaterialSettings rubber = window_->simulation()->settings().materials[0];
  rubber.poissons_ratio = 0.4999;
  make_edit(SetMaterial{0, rubber}, "Poisson's ratio 0.4999");
  expect_told(QStringLiteral("nearly incompressible"));
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(message(), QString());
}

// They began with a small letter, each one replaced the one before, and an edit repeated one of them.
TEST_F(Messages, WarningsOfTheSceneAreSentencesAndAreToldOnce) {
  Document document = quiet_beam();
  document.scene.material.poissons_ratio = 0.499;
  document.scene.time.tolerance = 1e-5;
  show(document);
  settle();
  const QString locking = QStringLiteral("A Poisson's ratio of 0.499 is nearly incompressible");
  expect_told(locking);
  expect_told(QStringLiteral("time.tolerance, time.min_step and time.max_step have no effect"));
  MaterialSettings material = window_->simulation()->settings().materials[0];
  for (const double ratio : {0.3, 0.499}) {
    material.poissons_ratio = ratio;
    make_edit(SetMaterial{0, material}, "Poisson's ratio");
  }
  EXPECT_EQ(message().count(locking), 1) << message().toStdString();
}

TEST_F(Messages, ARefusedInputGoesWithTheNextAction) {
  show(quiet_beam());
  make_edit(SetDamping{{.drag = 0.2}}, "Drag");
  window_->select({nearest({1.2, 0.3, 0.3})});
  raise("dock_vertices");
  NumberField* field = find<NumberField>("position_x");
  type(field, "abc");
  wait();
  expect_told(QStringLiteral("is not possible"));
  QTest::keyClick(field, Qt::Key_Escape);
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(message(), QString());
}

TEST_F(Messages, ADragThatStopsIsToldUntilItEnds) {
  show(quiet_beam());
  trigger("tool_3");
  const Index tip = nearest({1.2, 0.3, 0.3});
  QString told;
  while_pressed_ = [&] {
    wait_for([this] { return !message().isEmpty(); }, 5000);
    told = message();
  };
  drag(place_of(tip), place_of(nearest({0.3, 0.3, 0.3})), Qt::AltModifier);
  EXPECT_TRUE(told.contains(QStringLiteral("The drag stops here"))) << told.toStdString();
  settle();
  EXPECT_EQ(message(), QString());
}

// The window told the forecast of the edit instead of the failure that came of it.
TEST_F(Messages, TheFirstFailureAfterMidpointToExplicitIsTheFailure) {
  Document document = falling_beam();
  document.scene.time.integrator = Integrator::kMidpoint;
  document.scene.time.retry = 0;
  show(std::move(document));
  show_entry("time");
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([this] { return state().step > 5; }));
  auto* integrator = find<QComboBox>("integrator");
  integrator->setFocus();
  QTest::keyClick(integrator, Qt::Key_Home);  // explicit
  ASSERT_TRUE(wait_for([this] { return way_back() != nullptr; }));
  wait(500);
  EXPECT_EQ(state().status, RunStatus::kUnstable);
  EXPECT_EQ(window_->messages()->text(QStringLiteral("failure")),
            QString::fromStdString(state().message));
  EXPECT_EQ(message(), QString::fromStdString(state().message)) << "and no forecast beside it";
  keep_picture("first_failure");
  EXPECT_NE(action_button(QStringLiteral("Half the step")), nullptr);
  EXPECT_NE(action_button(QStringLiteral("backward-euler")), nullptr);
  EXPECT_NE(action_button(QStringLiteral("Back before")), nullptr);
  answer(QStringLiteral("Back before"));
  EXPECT_EQ(state().status, RunStatus::kRunning);
  EXPECT_EQ(window_->simulation()->settings().time.integrator, Integrator::kMidpoint);
}

TEST_F(Messages, ARestartCanBeUndoneInTheWindow) {
  show(falling_beam());
  run_to(0.1);
  const double time = state().time;
  const std::size_t rows = window_->chart()->row_count();
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(state().step, 0);
  EXPECT_TRUE(menu_action(QStringLiteral("&Undo"))->text().contains(QStringLiteral("Restart")));
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(state().time, time);
  EXPECT_EQ(window_->chart()->row_count(), rows);
}

}  // namespace
}  // namespace tetraction::viewer
