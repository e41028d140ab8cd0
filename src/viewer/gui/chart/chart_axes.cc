// The axes of the chart: ranges, ticks, and the lines that reach from end to end.
#include "chart_axes.h"

#include <vtkAxis.h>
#include <vtkChartXY.h>
#include <vtkPlotLine.h>
#include <vtkStringArray.h>

#include "live_chart.h"
#include "viewer/display_units.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {

// Sets the axes to the range of the visible series, unless the user has zoomed. Also sets the lines of
// the marks.
void LiveChart::scale() {
  vtkAxis* x = chart_->GetAxis(vtkAxis::BOTTOM);
  vtkAxis* y = chart_->GetAxis(vtkAxis::LEFT);
  if (following_) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    const auto& shown = shown_[static_cast<std::size_t>(kind_)];
    for (std::size_t s = 0; s < shown.size(); ++s) {
      if (!shown[s]) continue;
      for (vtkTable* table : {table_.Get(), other_table_.Get()}) {
        const vtkDoubleArray* array = column(table, static_cast<int>(s) + 1);
        for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
          const double value = array->GetValue(i);
          if (!(std::abs(value) < kLargest)) continue;
          low = std::min(low, value);
          high = std::max(high, value);
        }
      }
    }
    if (!(low <= high)) low = high = 0.0;
    constexpr double kDecades = 12.0;
    if (logarithmic_) low = std::max(low, high - kDecades);
    double room = 0.06 * (high - low);
    // The range is not smaller than round-off, which is in proportion to the volume of the body.
    const double unit = std::pow(std::min(size_, 1.0), 3);
    const double size = std::max(std::abs(low), std::abs(high));
    if (room < 1e-12 * unit || !is_drawable(low, high)) {
      room = size < 1e-12 * unit ? unit : 0.1 * size;
    }
    y->SetRange(low - room, high + room);
    const double begin = rows_.empty() ? 0.0 : rows_.front().time;
    double end = rows_.empty() ? 1.0 : rows_.back().time;
    if (!other_rows_.empty()) end = std::max(end, other_rows_.back().time);
    x->SetRange(begin, is_drawable(begin, end) ? end : begin + std::max(1.0, 0.1 * begin));
  }
  bottom_ = y->GetMinimum();
  top_ = y->GetMaximum();

  // The marks are one line with gaps: NaN separates the vertical parts.
  vtkDoubleArray* time = column(mark_table_, 0);
  vtkDoubleArray* line = column(mark_table_, 1);
  time->SetNumberOfTuples(0);
  line->SetNumberOfTuples(0);
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const EditMark& mark = marks_[i];
    // Only the first of consecutive edits with the same text, such as those of a drag, is marked.
    if (i > 0 && marks_[i - 1].what == mark.what) continue;
    for (const double place : {bottom_, top_, kNaN}) {
      time->InsertNextValue(mark.time);
      line->InsertNextValue(place);
    }
  }
  marks_plot_->SetVisible(!marks_.empty());
  vtkDoubleArray* cursor_time = column(cursor_table_, 0);
  vtkDoubleArray* cursor_line = column(cursor_table_, 1);
  cursor_time->SetNumberOfTuples(2);
  cursor_line->SetNumberOfTuples(2);
  for (vtkIdType i = 0; i < 2; ++i) {
    cursor_time->SetValue(i, std::isfinite(cursor_) ? cursor_ : 0.0);
    cursor_line->SetValue(i, i == 0 ? bottom_ : top_);
  }
  cursor_plot_->SetVisible(std::isfinite(cursor_));
  for (vtkTable* table : {mark_table_.Get(), cursor_table_.Get()}) {
    column(table, 0)->Modified();
    column(table, 1)->Modified();
    table->Modified();
  }
  marks_plot_->Modified();
  cursor_plot_->Modified();
}

// Sets round numbers at the ticks of both axes, as many as the size of the chart allows.
void LiveChart::set_ticks() {
  for (const int side : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
    vtkAxis* axis = chart_->GetAxis(side);
    // Ticks at round numbers are at round numbers in every unit.
    const DisplayUnit unit = display_unit(side == vtkAxis::LEFT ? kind().unit : time_unit());
    const double low = axis->GetMinimum();
    const double high = axis->GetMaximum();
    if (!is_drawable(low, high)) continue;
    const int wanted = side == vtkAxis::LEFT ? widget_->height() / 40 : widget_->width() / 110;
    vtkNew<vtkDoubleArray> places;
    vtkNew<vtkStringArray> labels;
    for (const double tick : axis_ticks(low, high, wanted)) {
      places->InsertNextValue(tick);
      const bool is_power = logarithmic_ && side == vtkAxis::LEFT;
      labels->InsertNextValue(QString::number(unit.from_si(is_power ? std::pow(10.0, tick) : tick),
                                              'g', is_power ? 2 : 4)
                                  .toStdString());
    }
    axis->SetCustomTickPositions(places, labels);
  }
}

std::array<std::vector<double>, 2> LiveChart::ticks() const {
  std::array<std::vector<double>, 2> both;
  for (const int side : {vtkAxis::BOTTOM, vtkAxis::LEFT}) {
    vtkDoubleArray* places = chart_->GetAxis(side)->GetTickPositions();
    for (vtkIdType i = 0; i < places->GetNumberOfTuples(); ++i) {
      both[side == vtkAxis::LEFT ? 1 : 0].push_back(places->GetValue(i));
    }
  }
  return both;
}

}  // namespace tetraction::viewer
