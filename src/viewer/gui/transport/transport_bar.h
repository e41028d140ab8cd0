// The bar below the picture: run, pause and step, the time, the speed, and a slider over the time of the run.
#pragma once

#include <QElapsedTimer>
#include <QWidget>
#include <vector>

#include "timeline.h"
#include "viewer/gui/chart/chart_series.h"

class QAction;
class QCheckBox;
class QComboBox;
class QHBoxLayout;
class QLabel;
class QSpinBox;
class QTimer;

namespace tetraction::viewer {

/// Serves a simulation and a replay. Its stops are the kept states of the one and the frames of the other. It
/// says which time is to be shown, and is told what is shown.
class TransportBar : public QWidget {
  Q_OBJECT

 public:
  explicit TransportBar(QWidget* parent = nullptr);

  /// Buttons for actions, in this order.
  void add_buttons(const std::vector<std::pair<const char*, QAction*>>& actions);
  /// The stops of a replay, of which the first one is shown.
  void begin_replay(const std::vector<double>& times, RunKind kind);
  void begin_simulation();
  /// The state of a simulation and the times of its kept states.
  void show_simulation(const Snapshot& snapshot, const std::vector<double>& kept);
  /// The frame that a replay shows.
  void show_frame(std::size_t frame);
  std::size_t frame() const { return stop_; }
  Timeline* timeline() const { return timeline_; }
  /// The ends of the chart's axis, in pixels of this widget, and its range. With an empty range the slider
  /// has the whole run and the whole width.
  void follow_axis(int left, int right, double first, double last);

  /// Goes to another stop: 1 is the next one, −1 the one before.
  void go(int direction);
  /// Goes to the stop that is nearest to a time.
  void go_to(double time);
  /// Plays a replay.
  void play(bool on);
  bool playing() const;
  /// Simulated seconds in a second; 0: as fast as it goes.
  double speed() const;
  void set_speed(double speed);
  int steps_per_picture() const;

 signals:
  /// A time of a simulation, s, or a frame of a replay is to be shown.
  void time_wanted(double time);
  void frame_wanted(std::size_t frame);
  void playing_changed(bool on);
  void speed_changed(double speed);
  void steps_changed(int steps);

 private:
  void begin(bool replay, RunKind kind);
  void show(double time, const QString& details);
  void choose_speed(double duration);
  void play_on();
  std::size_t nearest(double time) const;

  bool replay_ = false;
  RunKind kind_ = RunKind::kMotion;
  std::vector<double> stops_;
  std::size_t stop_ = 0;  // of a replay
  double shown_ = 0.0;    // time
  double played_ = 0.0;   // time to which a replay has been played
  QElapsedTimer since_played_;
  QHBoxLayout *buttons_, *slider_row_;
  Timeline* timeline_;
  QLabel *time_, *details_;
  QComboBox* speed_;
  QSpinBox* steps_;
  QCheckBox* loop_;
  QTimer* timer_;
};

}  // namespace tetraction::viewer
