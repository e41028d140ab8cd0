// The time slider of a replay.
#pragma once

#include <QWidget>
#include <vector>

#include "viewer/gui/chart/chart_series.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QSlider;
class QTimer;
class QToolButton;

namespace tetraction::viewer {

class ReplayBar : public QWidget {
  Q_OBJECT

 public:
  explicit ReplayBar(QWidget* parent = nullptr);

  /// The times of the frames, s, or the load factors of an equilibrium.
  void set_times(const std::vector<double>& times, RunKind kind);
  int frame() const;
  void set_frame(int frame);
  /// Shows the frame nearest to a time.
  void set_time(double time);
  void play(bool on);
  bool playing() const;
  /// Shows the next frame. Has no effect at the last one.
  void forward();

 signals:
  void frame_wanted(int frame);

 private:
  void show_time();

  std::vector<double> times_;
  RunKind kind_ = RunKind::kMotion;
  QSlider* slider_;
  QToolButton* play_;
  QCheckBox* loop_;
  QComboBox* speed_;
  QLabel* label_;
  QTimer* timer_;
};

}  // namespace tetraction::viewer
