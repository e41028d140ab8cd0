// What the window tells about the run: failures, pauses, notices.
#include <QAction>
#include <QStatusBar>
#include <cmath>
#include <utility>

#include "main_window.h"
#include "viewer/gui/body/body_view.h"

namespace tetraction::viewer {
namespace {

QString text(const std::string& utf8) {
  return QString::fromUtf8(utf8.c_str());
}

const QString kFailure = QStringLiteral("failure");
const QString kPause = QStringLiteral("pause");

}  // namespace

// Makes an edit that answers a failure or an energy error, in a state that can be changed.
void MainWindow::answer(TimeSettings time, const QString& what) {
  if (!simulation_) return;
  leave_failure();
  time.automatic = false;
  simulation_->edit(SetTime{time}, what.toStdString());
}

MessageAction MainWindow::half_step() {
  return {tr("Half the step"), [this] {
            TimeSettings time = simulation_->settings().time;
            time.step *= 0.5;
            answer(time, tr("Step %1 s").arg(time.step));
          }};
}

MessageAction MainWindow::other_rule(Integrator rule) {
  const QString name = QString::fromStdString(to_string(rule));
  return {name, [this, rule, name] {
            TimeSettings time = simulation_->settings().time;
            time.integrator = rule;
            if (!is_variational(rule)) time.adapt = StepAdaptation::kNone;
            answer(time, tr("Integrator %1").arg(name));
          }};
}

MessageAction MainWindow::before_last_edit() {
  return {tr("Back before “%1”").arg(text(simulation_->undo_text())),
          [this] { simulation_->go_before_last_edit(); }};
}

void MainWindow::show_failure(const Snapshot& snapshot) {
  const bool failed =
      snapshot.status == RunStatus::kUnstable || snapshot.status == RunStatus::kNotConverged;
  if (failed == failed_ || !simulation_) return;
  failed_ = failed;
  go_back_->setEnabled(failed);
  back_->setEnabled(!failed);
  if (!failed) {
    messages_->end(kFailure);
    statusBar()->showMessage(tr("At the last good state, %1 s").arg(snapshot.time), 8000);
    return;
  }
  for (const QString& cause : edit_warnings_) messages_->end(cause);
  edit_warnings_.clear();
  const TimeSettings time = simulation_->settings().time;
  std::vector<MessageAction> actions{
      {tr("Back to the last good state"), [this] { go_back_->trigger(); }}};
  if (snapshot.knows_last_edit) actions.push_back(before_last_edit());
  if (time.adapt == StepAdaptation::kNone) actions.push_back(half_step());
  if (time.integrator != Integrator::kBackwardEuler) {
    actions.push_back(other_rule(Integrator::kBackwardEuler));
  }
  if (snapshot.failed_element >= 0) {
    actions.push_back(
        {tr("Show element %1").arg(simulation_->mesh().tetrahedron_id(snapshot.failed_element)),
         [this, e = snapshot.failed_element] { view_->show_element(simulation_->mesh(), e); }});
  }
  messages_->show_message(MessageStrip::Kind::kError, text(snapshot.message), kFailure,
                          std::move(actions));
}

// A run that has paused by itself says why, with the ways to go on.
void MainWindow::show_pause(const Snapshot& snapshot) {
  if (snapshot.pause == shown_pause_) return;
  shown_pause_ = snapshot.pause;
  messages_->end(kPause);
  if (snapshot.pause == Pause::kNone) return;
  const auto run_on = [this] { simulation_->run(); };
  if (snapshot.pause == Pause::kEnd) {
    messages_->show_message(MessageStrip::Kind::kNote,
                            tr("The run has reached its end, %1 s.").arg(snapshot.time), kPause,
                            {{tr("Go on"), run_on}});
    return;
  }
  const auto and_run = [run_on](MessageAction action) {
    action.act = [act = std::move(action.act), run_on] {
      act();
      run_on();
    };
    return action;
  };
  const TimeSettings time = simulation_->settings().time;
  std::vector<MessageAction> actions;
  if (time.integrator != Integrator::kEnergyMomentum && time.adapt != StepAdaptation::kEnergy) {
    actions.push_back(and_run(other_rule(Integrator::kEnergyMomentum)));
  }
  if (time.adapt == StepAdaptation::kNone) actions.push_back(and_run(half_step()));
  if (snapshot.knows_last_edit) actions.push_back(before_last_edit());
  actions.push_back({tr("Go on"), run_on});
  messages_->show_message(
      MessageStrip::Kind::kWarning,
      tr("The integrator has %1 %2 J, %3 % of the %4 J that entered. This is an error of the step, "
         "not of the body.")
          .arg(snapshot.energy_error > 0.0 ? tr("added") : tr("lost"))
          .arg(std::abs(snapshot.energy_error), 0, 'g', 3)
          .arg(100.0 * std::abs(snapshot.energy_error) / snapshot.energy_entered, 0, 'g', 3)
          .arg(snapshot.energy_entered, 0, 'g', 3),
      kPause, std::move(actions));
}

// Goes back to the last good state before the user changes a setting after a failure.
void MainWindow::leave_failure() {
  if (failed_ && simulation_) simulation_->go_back();
}

void MainWindow::show_notices() {
  for (const std::string& cause : simulation_->take_ended_causes()) messages_->end(text(cause));
  for (const Notice& notice : simulation_->take_notices()) {
    const QString cause = text(notice.cause);
    if (cause.startsWith(QLatin1String("edit"))) {
      if (failed_) continue;  // the failure has come that it warns of
      edit_warnings_.push_back(cause);
    }
    messages_->show_message(notice.kind == Notice::Kind::kRefused ? MessageStrip::Kind::kError
                            : notice.kind == Notice::Kind::kNote  ? MessageStrip::Kind::kNote
                                                                  : MessageStrip::Kind::kWarning,
                            text(notice.text), cause);
  }
}

// An input that was refused. What the user does next ends the message.
void MainWindow::show_refusal(const QString& message) {
  messages_->show_message(MessageStrip::Kind::kWarning, message, QStringLiteral("input"));
}

void MainWindow::end_refusal() {
  messages_->end(QStringLiteral("input"));
}

}  // namespace tetraction::viewer
