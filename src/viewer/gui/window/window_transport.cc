// The transport bar and the charts below it, which share the time.
#include <QAction>
#include <limits>

#include "main_window.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/chart/live_chart.h"
#include "viewer/gui/transport/transport_bar.h"
#include "viewer/gui/widgets/icons.h"

namespace tetraction::viewer {

void MainWindow::connect_transport() {
  restart_->setIcon(icon(Icon::kRestart));
  back_->setIcon(icon(Icon::kBack));
  step_->setIcon(icon(Icon::kStep));
  record_run_->setIcon(icon(Icon::kRecord));
  show_running(false);
  transport_->add_buttons({{"bar_restart", restart_},
                           {"bar_back", back_},
                           {"bar_run", run_},
                           {"bar_step", step_},
                           {"bar_record", record_run_},
                           {"continue_here", continue_}});
  connect(transport_, &TransportBar::playing_changed, this, &MainWindow::show_running);
  connect(transport_, &TransportBar::frame_wanted, this, &MainWindow::show_frame);
  connect(transport_, &TransportBar::time_wanted, this, [this](double time) {
    if (simulation_) simulation_->show_at(time);
  });
  connect(transport_, &TransportBar::speed_changed, this, [this](double factor) {
    if (simulation_) simulation_->set_speed_limit(factor);
  });
  connect(transport_, &TransportBar::steps_changed, this, [this](int steps) {
    if (simulation_) simulation_->set_steps_per_snapshot(steps);
  });
  connect(chart_, &LiveChart::time_clicked, transport_, &TransportBar::go_to);
}

void MainWindow::show_running(bool running) {
  if (run_->data().isValid() && run_->data().toBool() == running) return;
  run_->setData(running);
  run_->setIcon(icon(running ? Icon::kPause : Icon::kRun));
  run_->setToolTip(running ? tr("Pause (Space)") : tr("Run (Space)"));
}

// Shows the time and the kept states of the simulation, and puts the slider above the axis of the chart.
void MainWindow::update_transport() {
  if (const auto state = view_->state(); simulation_ && state) {
    if (!state->earlier) continue_->setVisible(false);  // makes room for what is shown again
    transport_->show_simulation(*state, simulation_->kept_times());
    transport_->timeline()->set_marks(simulation_->marks());
    chart_->set_cursor(state->earlier ? state->time : std::numeric_limits<double>::quiet_NaN());
    show_running(state->running);
    continue_->setVisible(state->earlier);
    continue_->setEnabled(state->earlier);
  }
  const bool above = chart_->isVisible() && chart_->window() == this;
  const auto place = [this](int x) {
    return transport_->mapFrom(this, chart_->canvas()->mapTo(this, QPoint(x, 0))).x();
  };
  const auto [first, last, low, high] = chart_->axis_ranges();
  const auto ends = above ? chart_->axis_ends() : std::array{0, 0};
  transport_->follow_axis(above ? place(ends[0]) : 0, above ? place(ends[1]) : 0, first, last);
}

}  // namespace tetraction::viewer
