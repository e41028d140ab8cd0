#include "live_chart.h"

#include <QVTKInteractor.h>
#include <vtkAxis.h>
#include <vtkCallbackCommand.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkCommand.h>
#include <vtkContextInteractorStyle.h>
#include <vtkContextMouseEvent.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkPen.h>
#include <vtkPlotLine.h>
#include <vtkRenderer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <QCheckBox>
#include <QComboBox>
#include <QEvent>
#include <QHBoxLayout>
#include <QTabBar>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <limits>

#include "chart_axes.h"
#include "viewer/gui/widgets/icons.h"
#include "viewer/gui/widgets/theme.h"
#include "viewer/gui/widgets/vtk_widget.h"

namespace tetraction::viewer {
namespace {

constexpr std::size_t kBuckets = 1000;  // a chart is not wider, in pixels

vtkDoubleArray* add_column(vtkTable* table, const char* name) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  table->AddColumn(array);
  return array;
}

}  // namespace

LiveChart::LiveChart(QWidget* parent)
    : QWidget(parent), cursor_(kNaN), widget_(new VtkWidget(window_, this)) {
  tabs_ = new QTabBar(this);
  tabs_->setObjectName(QStringLiteral("chart_tabs"));
  tabs_->setExpanding(false);
  tabs_->setDrawBase(false);
  QFont small = font();
  small.setPixelSize(static_cast<int>(TextSize::kSmall));
  tabs_->setFont(small);
  probe_choice_ = new QComboBox(this);
  probe_choice_->setObjectName(QStringLiteral("probe_choice"));
  probe_choice_->setToolTip(tr("The probe that is shown"));
  probe_choice_->hide();
  auto* logarithmic = new QCheckBox(tr("log"), this);
  logarithmic->setObjectName(QStringLiteral("logarithmic"));
  logarithmic->setToolTip(tr("Logarithms of the magnitudes"));
  logarithmic->setFocusPolicy(Qt::TabFocus);
  connect(logarithmic, &QCheckBox::toggled, this, [this](bool on) {
    logarithmic_ = on;
    following_ = stale_ = true;
    refresh();
  });
  const auto tool = [this](Icon picture, const QString& name, const char* object,
                           const QString& tip) {
    auto* button = new QToolButton(this);
    button->setObjectName(QLatin1String(object));
    button->setIcon(icon(picture));
    button->setAutoRaise(true);
    button->setFocusPolicy(Qt::TabFocus);
    button->setAccessibleName(name);
    button->setToolTip(tip);
    return button;
  };
  QToolButton* whole =
      tool(Icon::kWhole, tr("Whole run"), "whole_run",
           tr("Shows the whole run again after zooming (drag: zoom; wheel: in and out; "
              "middle button: move)"));
  QToolButton* save = tool(Icon::kSave, tr("Save"), "save_chart",
                           tr("Saves the data as CSV or the chart as PNG or SVG"));

  // The tabs need all the width of a small window, so that the tools are below the legend.
  auto* tools = new QHBoxLayout;
  tools->addWidget(logarithmic);
  tools->addStretch(1);
  tools->addWidget(whole);
  tools->addWidget(save);
  legend_ = new QVBoxLayout;
  legend_->setSpacing(3);
  auto* beside = new QVBoxLayout;
  beside->setContentsMargins(4, 4, 4, 4);
  beside->addWidget(probe_choice_);
  beside->addLayout(legend_, 1);
  beside->addLayout(tools);
  auto* row = new QHBoxLayout;
  row->addWidget(widget_, 1);
  row->addLayout(beside);
  auto* columns = new QVBoxLayout(this);
  columns->setContentsMargins(4, 2, 4, 4);
  columns->setSpacing(2);
  columns->addWidget(tabs_);
  columns->addLayout(row, 1);
  widget_->setMinimumSize(200, 110);
  widget_->setAccessibleName(tr("Chart"));

  window_->SetMultiSamples(0);
  view_->SetRenderWindow(window_);
  view_->SetInteractor(widget_->interactor());
  // VTK would draw a changed chart once more by a timer of its own. While Qt paints the widget, the
  // chart must be drawn in any case, because its last picture has been lost.
  widget_->interactor()->EnableRenderOff();
  vtkNew<vtkCallbackCommand> draw;
  draw->SetClientData(this);
  draw->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    auto* chart = static_cast<LiveChart*>(self);
    if (chart->widget_->painting() || chart->view_->GetScene()->GetDirty()) {
      chart->draw();
    }
  });
  widget_->interactor()->AddObserver(vtkCommand::RenderEvent, draw);
  chart_ = vtkSmartPointer<vtkChartXY>::New();
  view_->GetScene()->AddItem(chart_);
  // The axes are drawn even if there is no line, as before the first step.
  chart_->SetRenderEmpty(true);
  chart_->SetAutoAxes(false);
  for (const int side : {vtkAxis::TOP, vtkAxis::RIGHT}) chart_->GetAxis(side)->SetVisible(false);
  chart_->SetActionToButton(vtkChart::ZOOM, vtkContextMouseEvent::LEFT_BUTTON);
  chart_->SetActionToButton(vtkChart::PAN, vtkContextMouseEvent::MIDDLE_BUTTON);
  for (const int side : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
    vtkAxis* axis = chart_->GetAxis(side);
    axis->SetBehavior(vtkAxis::FIXED);
    set_type_face(axis->GetTitleProperties(), TextSize::kSmall);
    set_type_face(axis->GetLabelProperties(), TextSize::kSmall);
    // All labels have the same format, so that the width of the chart does not change often.
    axis->SetNotation(vtkAxis::PRINTF_NOTATION);
    axis->SetLabelFormat("%.4g");
  }
  // The legend of a saved chart. In the window there is a legend with check boxes beside the chart.
  chart_->GetLegend()->SetInline(false);
  chart_->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
  chart_->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);

  for (vtkTable* table : {mark_table_.Get(), cursor_table_.Get()}) {
    add_column(table, "time");
    add_column(table, "line");
  }
  chart_->SetTooltip(nullptr);  // show_values() has one
  widget_->setMouseTracking(true);
  widget_->installEventFilter(this);
  connect(tabs_, &QTabBar::currentChanged, this, &LiveChart::show_kind);
  connect(probe_choice_, QOverload<int>::of(&QComboBox::activated), this, &LiveChart::show_probe);
  connect(whole, &QToolButton::clicked, this, &LiveChart::show_whole_run);
  connect(save, &QToolButton::clicked, this, &LiveChart::save);
  set_run(RunKind::kMotion);
  set_colors();
  rebuild();
}

LiveChart::~LiveChart() = default;

void LiveChart::clear() {
  clear_rows();
  other_rows_.clear();
  marks_.clear();
  cursor_ = kNaN;
  following_ = true;
}

void LiveChart::clear_rows() {
  rows_.clear();
  stale_ = true;
}

void LiveChart::append(const std::vector<HistoryRow>& rows) {
  if (rows.empty()) return;
  rows_.insert(rows_.end(), rows.begin(), rows.end());
  stale_ = true;
}

void LiveChart::set_other_rows(std::vector<HistoryRow> rows) {
  other_rows_ = std::move(rows);
  stale_ = true;
}

void LiveChart::set_marks(const std::vector<EditMark>& marks) {
  if (marks.size() != marks_.size()) stale_ = true;
  marks_ = marks;
}

void LiveChart::set_cursor(double time) {
  if (time == cursor_ || (std::isnan(time) && std::isnan(cursor_))) return;
  cursor_ = time;
  stale_ = true;
}

// Makes the tabs of a run of that kind, without its probes.
void LiveChart::set_run(RunKind run) {
  run_ = run;
  kind_ = 0;
  kinds_ = chart_kinds(run);
  shown_.clear();
  const QSignalBlocker quiet(tabs_);
  while (tabs_->count() > 0) tabs_->removeTab(0);
  for (const ChartKind& kind : kinds_) {
    tabs_->setTabToolTip(tabs_->addTab(QString::fromStdString(kind.tab)),
                         QString::fromStdString(kind.name));
    shown_.emplace_back(kind.series.size(), true);
  }
}

void LiveChart::set_probes(const std::vector<ChartProbe>& probes, RunKind run) {
  if (probes == probes_ && run == run_) return;
  if (run != run_) set_run(run);
  const int fixed = fixed_kinds();
  const bool showed_probe = kind_ >= fixed;
  probes_ = probes;
  kinds_ = chart_kinds(run_);
  shown_.resize(kinds_.size());
  probe_choice_->clear();
  for (const ChartProbe& probe : probes_) {
    kinds_.push_back(chart_kind_of(probe));
    shown_.emplace_back(probe.columns.size(), true);
    probe_choice_->addItem(QString::fromStdString(probe.name));
  }
  {
    const QSignalBlocker quiet(tabs_);
    if (probes_.empty() && tabs_->count() > fixed) tabs_->removeTab(fixed);
    if (!probes_.empty() && tabs_->count() == fixed) tabs_->addTab(tr("Probes"));
  }
  show_kind(showed_probe && probes_.empty() ? 0 : std::min(kind_, fixed));
}

void LiveChart::show_kind(int kind) {
  const int fixed = fixed_kinds();
  const bool is_probe = kind >= fixed;
  kind_ = is_probe ? fixed + std::max(0, probe_choice_->currentIndex()) : kind;
  probe_choice_->setVisible(is_probe && probes_.size() > 1);
  const QSignalBlocker quiet(tabs_);
  tabs_->setCurrentIndex(std::min(kind, fixed));
  following_ = true;
  rebuild();
  refresh();
}

void LiveChart::show_probe(int probe) {
  probe_choice_->setCurrentIndex(probe);
  show_kind(fixed_kinds());
}

void LiveChart::show_whole_run() {
  following_ = true;
  stale_ = true;
  refresh();
}

// Makes the plots and the legend of the present kind of chart.
void LiveChart::rebuild() {
  const ChartKind& kind = this->kind();
  chart_->ClearPlots();
  plots_.clear();
  other_plots_.clear();
  for (vtkTable* table : {table_.Get(), other_table_.Get()}) {
    table->Initialize();
    add_column(table, "time");
  }
  while (QLayoutItem* item = legend_->takeAt(0)) {
    delete item->widget();
    delete item;
  }
  const auto add_line = [this](vtkTable* table, int y, int r, int g, int b, float width) {
    auto* plot = vtkPlotLine::SafeDownCast(chart_->AddPlot(vtkChart::LINE));
    plot->SetInputData(table, 0, y);
    plot->SetColor(static_cast<unsigned char>(r), static_cast<unsigned char>(g),
                   static_cast<unsigned char>(b), 255);
    plot->SetWidth(width * static_cast<float>(widget_->devicePixelRatioF()));
    plot->SetVisible(false);  // a line needs two points
    plot->SetLabel("");       // not in the legend
    return plot;
  };
  marks_plot_ = add_line(mark_table_, 1, 150, 150, 160, 1.0F);
  marks_plot_->GetPen()->SetLineType(vtkPen::DASH_LINE);
  cursor_plot_ = add_line(cursor_table_, 1, 90, 90, 90, 1.0F);
  for (std::size_t s = 0; s < kind.series.size(); ++s) {
    const ChartSeries& series = kind.series[s];
    add_column(table_, series.name.c_str());
    const bool is_black = series.color == kBlack;  // black lines have the colour of the texts
    const QColor color = is_black ? theme_colors().field.text
                                  : QColor(series.color[0], series.color[1], series.color[2]);
    vtkPlotLine* plot =
        add_line(table_, static_cast<int>(s) + 1, color.red(), color.green(), color.blue(), 1.6F);
    plot->SetLabel(series.name);
    plots_.push_back(plot);
    add_column(other_table_, series.name.c_str());
    vtkPlotLine* other = add_line(other_table_, static_cast<int>(s) + 1, color.red(), color.green(),
                                  color.blue(), 1.6F);
    other->GetPen()->SetLineType(vtkPen::DASH_LINE);
    other_plots_.push_back(other);

    auto* check = new QCheckBox(QString::fromStdString(series.name), this);
    check->setObjectName(QStringLiteral("series_%1").arg(s));
    check->setChecked(shown_[static_cast<std::size_t>(kind_)][s]);
    check->setToolTip(tr("Show or hide this series"));
    QPixmap patch(18, 4);
    patch.fill(color);
    check->setIcon(patch);
    check->setIconSize(patch.size());
    legend_->addWidget(check);
    connect(check, &QCheckBox::toggled, this, [this, s](bool on) {
      shown_[static_cast<std::size_t>(kind_)][s] = on;
      stale_ = true;
      refresh();
    });
  }
  legend_->addStretch(1);
  show_units();
}

void LiveChart::show_units() {
  const std::string time = run_ == RunKind::kMotion ? "Time" : "Load factor";
  chart_->GetAxis(vtkAxis::BOTTOM)->SetTitle(axis_title(time, time_unit()));
  chart_->GetAxis(vtkAxis::LEFT)->SetTitle(axis_title(kind().axis, kind().unit));
  stale_ = true;
}

void LiveChart::fill() {
  fill(table_, rows_, plots_);
  fill(other_table_, other_rows_, other_plots_);
}

void LiveChart::fill(vtkTable* table, const std::vector<HistoryRow>& rows,
                     const std::vector<vtkPlotLine*>& plots) {
  const ChartKind& kind = this->kind();
  const ThinnedSeries thinned = thin(rows, kind.series, kBuckets);
  const auto count = static_cast<vtkIdType>(thinned.time.size());
  for (int c = 0; c <= static_cast<int>(kind.series.size()); ++c) {
    vtkDoubleArray* array = column(table, c);
    const std::vector<double>& from =
        c == 0 ? thinned.time : thinned.values[static_cast<std::size_t>(c) - 1];
    array->SetNumberOfTuples(count);
    std::transform(from.begin(), from.end(), array->GetPointer(0), [&](double value) {
      if (c == 0 || !logarithmic_) return value;
      return value == 0.0 ? kNaN : std::log10(std::abs(value));
    });
    array->Modified();
  }
  table->Modified();
  for (std::size_t s = 0; s < plots.size(); ++s) {
    plots[s]->SetVisible(count > 1 && shown_[static_cast<std::size_t>(kind_)][s]);
    plots[s]->Modified();
  }
}

void LiveChart::refresh() {
  if (!stale_ || !widget_->isValid() || !isVisible()) return;
  stale_ = false;
  fill();
  scale();
  view_->GetScene()->SetDirty(true);
  draw();
}

void LiveChart::draw() {
  set_ticks();
  window_->Render();
}

void LiveChart::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange) {
    // Later, because this deletes widgets to which Qt is about to send the event.
    QTimer::singleShot(0, this, [this] {
      set_colors();
      rebuild();
      refresh();
    });
  }
  QWidget::changeEvent(event);
}

void LiveChart::set_colors() {
  const ThemeColors& colors = theme_colors();
  const auto bytes = [](const QColor& c) {
    return vtkColor4ub(static_cast<unsigned char>(c.red()), static_cast<unsigned char>(c.green()),
                       static_cast<unsigned char>(c.blue()), 255);
  };
  const QColor& ground = colors.field.ground;
  const QColor& ink = colors.field.text;
  view_->GetRenderer()->SetBackground(ground.redF(), ground.greenF(), ground.blueF());
  for (const int side : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
    vtkAxis* axis = chart_->GetAxis(side);
    axis->GetPen()->SetColor(bytes(colors.border));
    axis->GetGridPen()->SetColor(bytes(colors.grid));
    for (vtkTextProperty* text : {axis->GetTitleProperties(), axis->GetLabelProperties()}) {
      text->SetColor(ink.redF(), ink.greenF(), ink.blueF());
    }
  }
}

QWidget* LiveChart::canvas() const {
  return widget_;
}

}  // namespace tetraction::viewer
