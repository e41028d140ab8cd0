// Charts of the history of a run.
#pragma once

#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <QImage>
#include <QPointF>
#include <QWidget>
#include <array>
#include <vector>

#include "chart_series.h"
#include "viewer/snapshot.h"

class QCheckBox;
class QComboBox;
class QTabBar;
class QVBoxLayout;
class vtkChartXY;
class vtkContextView;
class vtkGenericOpenGLRenderWindow;
class vtkPlotLine;
class vtkTable;

namespace tetraction::viewer {

class VtkWidget;

/// Shows one of the charts of chart_kinds(), or one of a probe, over time or over the load factor. New rows
/// can be appended during a run.
class LiveChart : public QWidget {
  Q_OBJECT

 public:
  explicit LiveChart(QWidget* parent = nullptr);
  ~LiveChart() override;

  /// Removes all data, for another body or a run that is started again.
  void clear();
  /// The length of the body, m. The energies of the round-off of a small body are smaller, too.
  void set_body_size(double length) { size_ = length; }
  /// The probes whose values the rows have, and the kind of the run. Without probes there is no tab for
  /// them.
  void set_probes(const std::vector<ChartProbe>& probes, RunKind run = RunKind::kMotion);
  /// Removes the rows only, for other rows of the same run.
  void clear_rows();
  /// Appends new rows.
  void append(const std::vector<HistoryRow>& rows);
  void set_marks(const std::vector<EditMark>& marks);
  /// Draws a vertical line at the time that a replay shows. No line if the time is not finite.
  void set_cursor(double time);
  /// The rows of another run, whose curves are dashed. Empty: there is none.
  void set_other_rows(std::vector<HistoryRow> rows);
  const std::vector<HistoryRow>& other_rows() const { return other_rows_; }
  std::size_t row_count() const { return rows_.size(); }
  const std::vector<HistoryRow>& rows() const { return rows_; }

  /// Draws the chart if its data have changed.
  void refresh();
  QWidget* canvas() const;
  /// Where the horizontal axis begins and ends, in pixels of the canvas.
  std::array<int, 2> axis_ends() const;
  /// The ranges of the axes: first and last time (s), least and largest value.
  std::array<double, 4> axis_ranges() const;
  /// The title of the horizontal axis.
  std::string horizontal_title() const;
  /// The numbers at the ticks of the axes, horizontal and vertical.
  std::array<std::vector<double>, 2> ticks() const;
  /// Shows a kind of chart: one of chart_kinds(), or one more for the probe that is chosen.
  void show_kind(int kind);
  /// Shows the chart of the probe with this number.
  void show_probe(int probe);
  /// Saves all rows (.csv), or the visible chart with a legend (.png, .svg). The ending of the name
  /// decides.
  void save_as(const QString& path);

 public slots:
  void show_whole_run();
  void save();
  /// Shows the numbers in the present units.
  void show_units();

 signals:
  void message_ready(const QString& message);
  /// The user has clicked on the chart at this time, s, or load factor.
  void time_clicked(double time);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  const ChartKind& kind() const { return kinds_[static_cast<std::size_t>(kind_)]; }
  const char* time_unit() const { return run_ == RunKind::kMotion ? "s" : ""; }
  int fixed_kinds() const { return static_cast<int>(chart_kinds(run_).size()); }
  void set_run(RunKind run);
  bool save_picture(const QString& path);
  void set_colors();
  void rebuild();
  void fill();
  void fill(vtkTable* table, const std::vector<HistoryRow>& rows,
            const std::vector<vtkPlotLine*>& plots);
  void scale();
  void set_ticks();
  void draw();
  void show_values(const QPoint& place);
  double time_at(double x) const;

  std::vector<HistoryRow> rows_, other_rows_;
  std::vector<EditMark> marks_;
  double cursor_;
  bool stale_ = true;      // whether the chart must be drawn again
  bool following_ = true;  // whether the axes show the whole run
  double size_ = 1.0;      // of the body, m
  bool logarithmic_ = false;
  QPointF pressed_at_;
  bool pressed_ = false;  // whether a mouse button is pressed on the chart
  RunKind run_ = RunKind::kMotion;
  std::vector<ChartKind> kinds_;  // chart_kinds(run_), then one for each probe
  std::vector<ChartProbe> probes_;
  int kind_ = 0;                          // index in kinds_
  std::vector<std::vector<bool>> shown_;  // by kind and series
  double top_ = 1.0, bottom_ = 0.0;       // ends of the lines of the marks

  QTabBar* tabs_;
  QComboBox* probe_choice_;
  QVBoxLayout* legend_;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  VtkWidget* widget_;  // shows window_
  vtkNew<vtkContextView> view_;
  vtkSmartPointer<vtkChartXY> chart_;
  vtkNew<vtkTable> table_, other_table_;
  vtkNew<vtkTable> mark_table_;
  vtkNew<vtkTable> cursor_table_;
  vtkPlotLine* marks_plot_ = nullptr;
  vtkPlotLine* cursor_plot_ = nullptr;
  std::vector<vtkPlotLine*> plots_, other_plots_;
};

}  // namespace tetraction::viewer
