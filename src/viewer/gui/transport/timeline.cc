#include "timeline.h"

#include <QHelpEvent>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QStyle>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

constexpr int kValues = 100'000;
constexpr int kNearest = 3;  // ticks are not drawn nearer to each other, pixels
constexpr int kFlag = 6;     // pixels

}  // namespace

Timeline::Timeline(QWidget* parent) : QSlider(Qt::Horizontal, parent) {
  setObjectName(QStringLiteral("timeline"));
  setAccessibleName(tr("Time"));
  setRange(0, kValues);
  setFocusPolicy(Qt::TabFocus);
  setMinimumHeight(24);
  connect(this, &QSlider::valueChanged, this, [this] { emit time_wanted(time()); });
}

void Timeline::set_stops(const std::vector<double>& stops) {
  if (stops == stops_) return;
  stops_ = stops;
  update();
}

void Timeline::set_marks(const std::vector<EditMark>& marks) {
  if (marks.size() == marks_.size()) return;
  marks_ = marks;
  update();
}

void Timeline::set_span(double first, double last) {
  if (first == first_ && last == last_) return;
  const double shown = time();
  first_ = first;
  last_ = last;
  show_time(shown);
  update();
}

int Timeline::value_of(double time) const {
  const double part = last_ > first_ ? (time - first_) / (last_ - first_) : 0.0;
  return static_cast<int>(std::lround(std::clamp(part, 0.0, 1.0) * kValues));
}

void Timeline::show_time(double time) {
  if (isSliderDown()) return;
  const QSignalBlocker quiet(this);
  setValue(value_of(time));
}

double Timeline::time() const {
  if (value() == kValues) return last_;
  return first_ + (last_ - first_) * value() / kValues;
}

int Timeline::margin() const {
  return style()->pixelMetric(QStyle::PM_SliderLength, nullptr, this) / 2;
}

int Timeline::place_of(double time) const {
  return margin() +
         QStyle::sliderPositionFromValue(0, kValues, value_of(time), width() - 2 * margin());
}

void Timeline::paintEvent(QPaintEvent* event) {
  QSlider::paintEvent(event);
  QPainter painter(this);
  painter.setPen(palette().color(QPalette::Mid));
  int last = -kNearest;
  for (const double stop : stops_) {
    const int x = place_of(stop);
    if (x < last + kNearest || stop < first_ || stop > last_) continue;
    painter.drawLine(x, height() - 3, x, height() - 1);
    last = x;
  }
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(Qt::NoPen);
  painter.setBrush(palette().color(QPalette::Highlight));
  for (const EditMark& mark : marks_) {
    if (mark.time < first_ || mark.time > last_) continue;
    const int x = place_of(mark.time);
    painter.drawPolygon(QPolygon({{x, 0}, {x + kFlag, kFlag / 2}, {x, kFlag}}));
  }
}

void Timeline::mousePressEvent(QMouseEvent* event) {
  setSliderDown(event->button() == Qt::LeftButton);
  mouseMoveEvent(event);
}

void Timeline::mouseMoveEvent(QMouseEvent* event) {
  if (!isSliderDown()) return;
  setValue(QStyle::sliderValueFromPosition(0, kValues, event->pos().x() - margin(),
                                           width() - 2 * margin()));
}

void Timeline::mouseReleaseEvent(QMouseEvent* /*event*/) {
  setSliderDown(false);
}

void Timeline::keyPressEvent(QKeyEvent* event) {
  if (event->key() == Qt::Key_Left || event->key() == Qt::Key_Right) {
    emit stop_wanted(event->key() == Qt::Key_Left ? -1 : 1);
    return;
  }
  QSlider::keyPressEvent(event);
}

bool Timeline::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QSlider::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  const auto near = [&](const EditMark& mark) {
    return std::abs(place_of(mark.time) - help->pos().x()) <= kFlag;
  };
  const auto mark = std::find_if(marks_.begin(), marks_.end(), near);
  QToolTip::showText(help->globalPos(),
                     mark == marks_.end()
                         ? toolTip()
                         : QString::fromStdString(mark->what + " at " + with_unit(mark->time, "s")),
                     this);
  return true;
}

}  // namespace tetraction::viewer
