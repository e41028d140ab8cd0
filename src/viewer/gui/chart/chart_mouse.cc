// The mouse over the chart: zoom, values, and clicks that go to a time.
#include <vtkAxis.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>

#include <QMouseEvent>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "chart_axes.h"
#include "live_chart.h"
#include "viewer/display_units.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {

std::array<int, 2> LiveChart::axis_ends() const {
  vtkAxis* x = chart_->GetAxis(vtkAxis::BOTTOM);
  const double ratio = widget_->devicePixelRatioF();
  return {static_cast<int>(x->GetPoint1()[0] / ratio), static_cast<int>(x->GetPoint2()[0] / ratio)};
}

double LiveChart::time_at(double x) const {
  const auto [first, last] = axis_ends();
  const auto ranges = axis_ranges();
  return ranges[0] + (x - first) / std::max(last - first, 1) * (ranges[1] - ranges[0]);
}

// The values of the visible series in the row that is nearest to the mouse, and the edits there.
void LiveChart::show_values(const QPoint& place) {
  const double time = time_at(place.x());
  const auto next = std::lower_bound(rows_.begin(), rows_.end(), time,
                                     [](const HistoryRow& row, double t) { return row.time < t; });
  if (next == rows_.end() && rows_.empty()) return QToolTip::hideText();
  const HistoryRow& row = next == rows_.end() ? rows_.back() : *next;
  const std::string time_text = with_unit(row.time, time_unit(), 5);
  QStringList lines{(run_ == RunKind::kMotion ? QStringLiteral("%1") : tr("load factor %1"))
                        .arg(QString::fromStdString(time_text))};
  const auto& shown = shown_[static_cast<std::size_t>(kind_)];
  for (std::size_t s = 0; s < shown.size(); ++s) {
    const ChartSeries& series = kind().series[s];
    if (!shown[s]) continue;
    lines +=
        QString::fromStdString(series.name + ": " + with_unit(series.value(row), kind().unit, 5));
  }
  const double near = 4.0 * std::abs(time_at(1.0) - time_at(0.0));
  for (const EditMark& mark : marks_) {
    if (std::abs(mark.time - time) <= near) lines += QString::fromStdString(mark.what);
  }
  lines.removeDuplicates();
  QToolTip::showText(widget_->mapToGlobal(place), lines.join(QLatin1Char('\n')), widget_);
}

std::array<double, 4> LiveChart::axis_ranges() const {
  vtkAxis* x = chart_->GetAxis(vtkAxis::BOTTOM);
  vtkAxis* y = chart_->GetAxis(vtkAxis::LEFT);
  return {x->GetMinimum(), x->GetMaximum(), y->GetMinimum(), y->GetMaximum()};
}

std::string LiveChart::horizontal_title() const {
  return chart_->GetAxis(vtkAxis::BOTTOM)->GetTitle();
}

bool LiveChart::eventFilter(QObject* watched, QEvent* event) {
  if (watched == widget_) {
    // Zooming ends where the numbers of the axis can no longer be distinguished.
    const bool zooms = event->type() == QEvent::Wheel ||
                       (event->type() == QEvent::MouseButtonPress &&
                        static_cast<QMouseEvent*>(event)->button() == Qt::LeftButton);
    const std::array<double, 4> ranges = axis_ranges();
    if (zooms && !(is_drawable(ranges[0], ranges[1]) && is_drawable(ranges[2], ranges[3]))) {
      return true;
    }
    // After the user has zoomed, the axes no longer follow the data. A click does not zoom.
    if (event->type() == QEvent::MouseButtonPress) {
      pressed_ = true;
      pressed_at_ = static_cast<QMouseEvent*>(event)->localPos();
    }
    if (event->type() == QEvent::MouseButtonRelease) {
      pressed_ = false;
      const QPointF place = static_cast<QMouseEvent*>(event)->localPos();
      if ((place - pressed_at_).manhattanLength() < 3.0) {
        const double time = time_at(place.x());
        if (time >= ranges[0] && time <= ranges[1]) emit time_clicked(time);
      }
    }
    if (event->type() == QEvent::MouseMove && !pressed_) {
      show_values(static_cast<QMouseEvent*>(event)->pos());
    }
    const bool dragged = event->type() == QEvent::MouseMove && pressed_;
    if (dragged || event->type() == QEvent::Wheel) following_ = false;
    if (event->type() == QEvent::Resize || event->type() == QEvent::Show) {
      view_->GetScene()->SetDirty(true);
    }
    if (event->type() == QEvent::KeyPress || event->type() == QEvent::KeyRelease) {
      event->ignore();
      return true;
    }
  }
  return QWidget::eventFilter(watched, event);
}

}  // namespace tetraction::viewer
