// The time slider of a replay.
#pragma once

#include <QWidget>
#include <vector>

class QLabel;
class QSlider;
class QTimer;
class QToolButton;

namespace tetraction::viewer {

class ReplayBar : public QWidget {
  Q_OBJECT

 public:
  explicit ReplayBar(QWidget* parent = nullptr);

  void set_times(const std::vector<double>& times);
  int frame() const;
  void set_frame(int frame);
  void play(bool on);
  bool playing() const;
  /// Shows the next frame. Has no effect at the last one.
  void forward();

 signals:
  void frame_wanted(int frame);

 private:
  void show_time();

  std::vector<double> times_;
  QSlider* slider_;
  QToolButton* play_;
  QLabel* label_;
  QTimer* timer_;
};

}  // namespace tetraction::viewer
