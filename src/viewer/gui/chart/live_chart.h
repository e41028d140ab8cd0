// Charts of a run's history, growing as it goes.
#pragma once

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <QImage>
#include <QWidget>
#include <array>
#include <vector>

#include "chart_series.h"
#include "viewer/snapshot.h"

class QCheckBox;
class QTabBar;
class QVBoxLayout;
class QVTKOpenGLNativeWidget;
class vtkChartXY;
class vtkContextView;
class vtkGenericOpenGLRenderWindow;
class vtkPlotLine;
class vtkTable;

namespace tetraction::viewer {

/// Energies, balance, momenta, iterations over time; one of them is seen at a time.
class LiveChart : public QWidget {
  Q_OBJECT

 public:
  explicit LiveChart(QWidget* parent = nullptr);
  ~LiveChart() override;

  /// For another body, or a run that begins anew.
  void clear();
  /// Clears the rows only. Other rows of the same run will replace them.
  void clear_rows();
  /// Rows that came since.
  void append(const std::vector<HistoryRow>& rows);
  void set_marks(const std::vector<EditMark>& marks);
  /// A line at the time that a replay shows; none if not finite.
  void set_cursor(double time);
  std::size_t row_count() const { return rows_.size(); }
  const std::vector<HistoryRow>& rows() const { return rows_; }

  /// Draws what is new.
  void refresh();
  QWidget* canvas() const;
  /// What the axes show: time from, to (s); values from, to.
  std::array<double, 4> axis_ranges() const;
  void show_kind(int kind);
  /// Saves by the ending of the name: .csv (all rows), .png or .svg (the visible chart).
  void save_as(const QString& path);

 public slots:
  void show_whole_run();
  void save();

 signals:
  void told(const QString& message);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void rebuild();
  void fill();
  void scale();

  std::vector<HistoryRow> rows_;
  std::vector<EditMark> marks_;
  double cursor_;
  bool stale_ = true;      // something to draw
  bool following_ = true;  // the axes fit the whole run
  bool pressed_ = false;   // a button, on the chart
  int kind_ = 0;
  std::array<std::vector<bool>, kChartKinds> shown_;  // by kind and series
  double top_ = 1.0, bottom_ = 0.0;                   // of the marks' lines

  QTabBar* tabs_;
  QVBoxLayout* legend_;
  QWidget* legend_box_;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  QVTKOpenGLNativeWidget* widget_;  // draws what is in window_
  vtkNew<vtkContextView> view_;
  vtkSmartPointer<vtkChartXY> chart_;
  vtkNew<vtkTable> table_;
  vtkNew<vtkTable> mark_table_;
  vtkNew<vtkTable> cursor_table_;
  vtkPlotLine* marks_plot_ = nullptr;
  vtkPlotLine* cursor_plot_ = nullptr;
  std::vector<vtkPlotLine*> plots_;
};

}  // namespace tetraction::viewer
