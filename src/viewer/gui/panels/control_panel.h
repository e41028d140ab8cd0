// The panel that controls the run: start and stop, speed.
#pragma once

#include <QWidget>

#include "viewer/simulation.h"

class QLabel;
class QPushButton;
class QSpinBox;

namespace tetraction::viewer {

class NumberField;

/// Shows the present state. It emits what the user wants, but does not do it.
class ControlPanel : public QWidget {
  Q_OBJECT

 public:
  explicit ControlPanel(QWidget* parent = nullptr);

  void show_state(const Snapshot& snapshot);
  int steps_between_pictures() const;
  double speed_limit() const;

 signals:
  void run_wanted(bool run);
  void step_wanted();
  void restart_wanted();
  void steps_per_picture(int steps);
  void speed_limited(double real_time_factor);
  void refused(const QString& message);

 private:
  bool running_ = false;
  QPushButton *run_, *step_, *restart_;
  QLabel *time_, *factor_;
  NumberField* speed_;
  QSpinBox* per_picture_;
};

}  // namespace tetraction::viewer
