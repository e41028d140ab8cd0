// The panel that controls the run: start and stop, time step, integrator, solver.
#pragma once

#include <QWidget>

#include "viewer/simulation.h"

class QComboBox;
class QLabel;
class QPushButton;
class QSpinBox;

namespace tetraction::viewer {

class NumberField;
class NumberSlider;

/// Shows the present settings. It emits the edits that the user wants, but does not make them.
class ControlPanel : public QWidget {
  Q_OBJECT

 public:
  explicit ControlPanel(QWidget* parent = nullptr);

  void show_settings(const Settings& settings);
  void show_state(const Snapshot& snapshot);
  int steps_between_pictures() const;
  double speed_limit() const;

 signals:
  void run_wanted(bool run);
  void step_wanted();
  void restart_wanted();
  void edited(tetraction::Edit edit, const QString& what, bool continues_previous);
  void steps_per_picture(int steps);
  void speed_limited(double real_time_factor);
  void refused(const QString& message);

 private:
  void time_edited(const QString& what, bool continues_previous);
  void solver_edited();
  void show_limit(double stable_step);

  Settings settings_;
  double stable_step_ = 0.0;
  bool running_ = false;
  QPushButton *run_, *step_, *restart_;
  QLabel *time_, *factor_, *limit_;
  NumberSlider* step_size_;
  QPushButton* half_limit_;
  NumberField *tolerance_, *speed_, *step_tolerance_;
  QComboBox *integrator_, *solver_, *adapt_;
  QSpinBox *iterations_, *per_picture_, *retry_;
};

}  // namespace tetraction::viewer
