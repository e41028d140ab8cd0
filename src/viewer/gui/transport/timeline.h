// The slider over the time of a run.
#pragma once

#include <QSlider>
#include <array>
#include <vector>

#include "viewer/snapshot.h"

namespace tetraction::viewer {

/// A slider whose positions are times, s, or load factors. It has ticks at the stops, which are the states
/// that can be shown, and flags at edits and events. A click goes there.
class Timeline : public QSlider {
  Q_OBJECT

 public:
  explicit Timeline(QWidget* parent = nullptr);

  void set_stops(const std::vector<double>& stops);
  void set_marks(const std::vector<EditMark>& marks);
  /// The first and the last time.
  void set_span(double first, double last);
  std::array<double, 2> span() const { return {first_, last_}; }
  /// Moves the handle, unless the mouse has it. Emits nothing.
  void show_time(double time);
  double time() const;
  /// Where a time is, in pixels from the left.
  int place_of(double time) const;
  /// The pixels to the left and to the right of the span.
  int margin() const;

 signals:
  void time_wanted(double time);
  /// To the next stop (1) or the one before (−1).
  void stop_wanted(int direction);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  bool event(QEvent* event) override;

 private:
  int value_of(double time) const;

  std::vector<double> stops_;
  std::vector<EditMark> marks_;
  double first_ = 0.0, last_ = 1.0;
};

}  // namespace tetraction::viewer
