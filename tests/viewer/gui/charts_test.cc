// Charts: rows, marks, series, zoom, files.
#include <QCheckBox>
#include <QComboBox>
#include <QFile>
#include <QGuiApplication>
#include <QScreen>
#include <QTabBar>
#include <QTemporaryDir>

#include <algorithm>
#include <limits>

#include "pictures.h"
#include "viewer/gui/chart/chart_series.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

using Charts = WindowTest;

TEST_F(Charts, GetRowsAndMarks) {
  show(first_scene());
  run_to(0.3);
  window_->simulation()->edit(SetDamping{{0.0, 2.0, 0.0}}, "Mass damping 2 1/s");
  run_to(0.6);
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(state().step) + 1);
  auto* tabs = find<QTabBar>("chart_tabs");
  for (int i = 0; i < tabs->count(); ++i) {
    QTest::mouseClick(tabs, Qt::LeftButton, Qt::NoModifier, tabs->tabRect(i).center());
    keep_picture(QStringLiteral("chart_%1").arg(i).toLatin1().constData());
  }
}

TEST_F(Charts, SeriesCanBeHidden) {
  show(first_scene());
  run_to(0.3);
  const QImage before = window_->chart()->grab().toImage();
  auto* check = find<QCheckBox>("series_0");
  QTest::mouseClick(check, Qt::LeftButton, Qt::NoModifier, QPoint(8, check->height() / 2));
  EXPECT_FALSE(check->isChecked());
  wait(300);
  EXPECT_NE(window_->chart()->grab().toImage(), before);
}

// Before the first step, and with every series hidden.
TEST_F(Charts, AxesAreThereWithoutLines) {
  show(quiet_beam());
  const auto lines = [this] {  // of the grid
    wait(300);
    const QImage image = window_->chart()->canvas()->grab().toImage();
    return pixels(image, [](QRgb c) { return !differ(c, qRgb(225, 225, 225)); }).size();
  };
  EXPECT_GT(lines(), 500U);
  press_and_settle(Qt::Key_S);
  for (const char* series : {"series_0", "series_1", "series_2", "series_3"}) click(series);
  EXPECT_GT(lines(), 500U);
}

TEST_F(Charts, EditsAreMarkedOnTheTimeAxis) {
  show(first_scene());
  show_entry("damping");
  run_to(0.2);
  const auto marks = [this] {
    wait(300);
    const QImage image = window_->chart()->canvas()->grab().toImage();
    // Dashed lines of this grey from the bottom to the top.
    std::vector<int> in_column(static_cast<std::size_t>(image.width()), 0);
    for (const QPoint& p : pixels(image, [](QRgb c) { return !differ(c, qRgb(150, 150, 160)); })) {
      ++in_column[static_cast<std::size_t>(p.x())];
    }
    int lines = 0;
    bool before = false;
    for (const int count : in_column) {
      const bool line = 5 * count > image.height();
      if (line && !before) ++lines;
      before = line;
    }
    return lines;
  };
  EXPECT_EQ(marks(), 0);
  enter("mass_damping", "0.5");
  run_to(state().time + 0.2);
  EXPECT_EQ(marks(), 1);
  enter("viscosity", "70");
  run_to(state().time + 0.2);
  EXPECT_EQ(marks(), 2);
  keep_picture("chart_marks");
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(marks(), 0);
}

TEST_F(Charts, HiddenSeriesStayHiddenInEachChart) {
  show(first_scene());
  run_to(0.3);
  auto* tabs = find<QTabBar>("chart_tabs");
  const auto choose = [&](int kind) {
    QTest::mouseClick(tabs, Qt::LeftButton, Qt::NoModifier, tabs->tabRect(kind).center());
    wait(200);
  };
  const auto orange = [this] {  // lines of series 1 in the chart itself
    const QImage image = window_->chart()->canvas()->grab().toImage();
    return pixels(image, [](QRgb c) { return !differ(c, qRgb(230, 159, 0)); }).size();
  };
  EXPECT_GT(orange(), 50U);
  click("series_1");
  wait(200);
  EXPECT_EQ(orange(), 0U);
  choose(3);
  EXPECT_TRUE(find<QCheckBox>("series_1")->isChecked());
  EXPECT_GT(orange(), 50U);
  click("series_0");
  choose(0);
  EXPECT_FALSE(find<QCheckBox>("series_1")->isChecked());
  EXPECT_TRUE(find<QCheckBox>("series_0")->isChecked());
  EXPECT_EQ(orange(), 0U);
  choose(3);
  EXPECT_FALSE(find<QCheckBox>("series_0")->isChecked());
  choose(0);
  click("series_1");
  wait(200);
  EXPECT_GT(orange(), 50U);
}

TEST_F(Charts, AreSavedAsCsvPngAndSvg) {
  show(first_scene());
  run_to(0.2);
  const QTemporaryDir folder;
  for (const char* name : {"chart.csv", "chart.png", "chart.svg"}) {
    const QString path = folder.filePath(QLatin1String(name));
    window_->chart()->save_as(path);
    QFile file(path);
    ASSERT_TRUE(file.open(QIODevice::ReadOnly)) << name;
    EXPECT_GT(file.size(), 1000) << name;
    if (QLatin1String(name) == QLatin1String("chart.csv")) {
      const auto lines = file.readAll().split('\n');
      EXPECT_EQ(static_cast<std::size_t>(lines.size()), window_->chart()->row_count() + 2);
    }
  }
}

TEST(ChartSeries, ThinningKeepsSpikes) {
  std::vector<HistoryRow> rows(100000);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].time = static_cast<double>(i);
  rows[54321].kinetic = 7.0;
  rows[54325].kinetic = -3.0;
  const ThinnedSeries thinned = thin(rows, chart_kinds()[0].series, 500);
  ASSERT_EQ(thinned.time.size(), 1000U);
  EXPECT_EQ(*std::max_element(thinned.values[0].begin(), thinned.values[0].end()), 7.0);
  EXPECT_EQ(*std::min_element(thinned.values[0].begin(), thinned.values[0].end()), -3.0);
}

// A row has values of probes; NaN where there are none.
TEST(ChartSeries, OfProbesLeaveRowsWithoutValuesOut) {
  const std::vector<ChartProbe> probes = chart_probes(
      {probe_of("tip", ProbeQuantity::kDisplacement), probe_of("s", ProbeQuantity::kVonMises)});
  ASSERT_EQ(probes.size(), 2U);
  EXPECT_EQ(axis_title(probes[0].axis, probes[0].unit), "tip: displacement [m]");
  EXPECT_EQ(axis_title(probes[1].axis, probes[1].unit), "s: von mises [Pa]");
  const ChartKind kind = chart_kind_of(probes[1]);
  ASSERT_EQ(kind.series.size(), 1U);
  EXPECT_EQ(kind.series[0].name, "s");
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<HistoryRow> rows(9);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time = static_cast<double>(i);
    rows[i].probes = {1.0, 2.0, 3.0, i % 4 == 0 ? 10.0 * static_cast<double>(i) : none};
  }
  rows[3].probes.clear();
  const ThinnedSeries thinned = thin(rows, kind.series, 500);
  EXPECT_EQ(thinned.time, (std::vector<double>{0.0, 4.0, 8.0}));
  EXPECT_EQ(thinned.values[0], (std::vector<double>{0.0, 40.0, 80.0}));
  EXPECT_EQ(thin(rows, chart_kind_of(probes[0]).series, 500).time.size(), 8U);
  const std::string text = history_text(rows, probes);
  EXPECT_NE(text.find("iterations,tip_x,tip_y,tip_z,s\n"), std::string::npos);
  EXPECT_NE(text.find(",1,2,3,40\n"), std::string::npos);
  EXPECT_NE(text.find(",1,2,3,\n"), std::string::npos);
}

TEST_F(Charts, OfProbesAreDrawnLive) {
  show(first_scene());
  auto* tabs = find<QTabBar>("chart_tabs");
  EXPECT_EQ(tabs->count(), 6);
  Document document = first_scene();
  const ProbeSettings tip = probe_of("tip", ProbeQuantity::kDisplacement, SelectPlane{0, 1.2, {}});
  document.scene.probe = {tip, probe_of("grip", ProbeQuantity::kReaction)};
  show(std::move(document));
  ASSERT_EQ(tabs->count(), 7);
  run_to(0.3);
  window_->chart()->show_kind(6);
  wait(200);
  EXPECT_EQ(tabs->currentIndex(), 6);
  const auto& rows = window_->chart()->rows();
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(state().step) + 1);
  // The mean displacement of the end of the last row is that of the shown state.
  const TetMesh& mesh = window_->simulation()->mesh();
  Vector3 mean = Vector3::Zero();
  const std::vector<Index> end = select_vertices(mesh, tip.select);
  for (const Index v : end) {
    mean += (state().position.segment<3>(3 * v) - mesh.vertices[static_cast<std::size_t>(v)]) /
            static_cast<double>(end.size());
  }
  ASSERT_EQ(rows.back().probes.size(), 6U);
  for (Index c = 0; c < 3; ++c) {
    EXPECT_NEAR(rows.back().probes[static_cast<std::size_t>(c)], mean[c], 1e-12);
  }
  const auto ranges = window_->chart()->axis_ranges();
  EXPECT_LT(ranges[2], mean.minCoeff());
  EXPECT_GT(ranges[3], mean.maxCoeff());
  auto* choice = find<QComboBox>("probe_choice");
  EXPECT_TRUE(choice->isVisible());
  keep_picture("chart_probe");
  window_->chart()->show_probe(1);
  wait(100);
  EXPECT_EQ(find<QCheckBox>("series_0")->text(), QStringLiteral("grip_x"));
  // The next scene has none.
  show(first_scene());
  EXPECT_EQ(tabs->count(), 6);
  EXPECT_EQ(tabs->currentIndex(), 0);
  EXPECT_FALSE(choice->isVisible());
}

// A canvas that was resized or became a window of its own is drawn again.
TEST_F(Charts, NoPartIsBlackAfterResizing) {
  show(first_scene());
  run_to(0.2);
  auto* dock = find<QDockWidget>("dock_charts");
  const auto black = [this] {
    wait(300);
    // What is on the screen: a picture of the canvas alone would be drawn for this purpose.
    const QWidget* canvas = window_->chart()->canvas();
    const QRect place(canvas->mapToGlobal(QPoint(0, 0)), canvas->size());
    const QImage image = QGuiApplication::primaryScreen()
                             ->grabWindow(0, place.x(), place.y(), place.width(), place.height())
                             .toImage();
    EXPECT_GT(image.width(), 100);
    const auto count = pixels(image, [](QRgb c) { return qGray(c) < 10; }).size();
    return static_cast<double>(count) / (image.width() * image.height());
  };
  EXPECT_LT(black(), 0.05);
  for (const QSize& size : {QSize(1100, 700), QSize(1200, 760), QSize(1000, 780)}) {
    window_->resize(size);
    EXPECT_LT(black(), 0.05) << size.width();
  }
  for (const bool floating : {true, false, true}) {
    dock->setFloating(floating);
    EXPECT_LT(black(), 0.05) << floating;
    if (floating) {
      dock->raise();
      dock->resize(500, 260);
      dock->move(60, 60);
      dock->resize(700, 330);
      EXPECT_LT(black(), 0.05);
    }
  }
  keep_picture("chart_floating");
}

TEST_F(Charts, SavedPicturesHaveALegend) {
  show(first_scene());
  run_to(0.3);
  window_->chart()->show_kind(0);
  wait(300);
  const QImage shown = window_->chart()->canvas()->grab().toImage();
  const QTemporaryDir folder;
  const auto saved = [&] {
    const QString path = folder.filePath(QStringLiteral("chart.png"));
    window_->chart()->save_as(path);
    return QImage(path).convertToFormat(shown.format());
  };
  // The columns of the picture where the frame of the legend has its vertical lines, right of the middle.
  const auto frame = [](const QImage& image) {
    std::vector<int> in_column(static_cast<std::size_t>(image.width()), 0);
    for (const QPoint& p : pixels(image, [](QRgb c) { return qGray(c) < 60; })) {
      ++in_column[static_cast<std::size_t>(p.x())];
    }
    std::vector<int> lines;
    for (int x = image.width() / 2; x < image.width(); ++x) {
      if (in_column[static_cast<std::size_t>(x)] > 30) lines.push_back(x);
    }
    return lines;
  };
  EXPECT_TRUE(frame(shown).empty());
  const auto in_legend = [&](const QImage& image, QRgb color) {
    const std::vector<int> lines = frame(image);
    if (lines.size() < 2) return false;
    const auto places = pixels(image, [color](QRgb c) { return !differ(c, color); });
    return std::any_of(places.begin(), places.end(), [&lines](const QPoint& p) {
      return p.x() > lines.front() && p.x() < lines.back();
    });
  };
  const QImage with_legend = saved();
  ASSERT_EQ(with_legend.size(), shown.size());
  EXPECT_EQ(frame(with_legend).size(), 2U);
  EXPECT_TRUE(in_legend(with_legend, qRgb(230, 159, 0)));
  EXPECT_TRUE(in_legend(with_legend, qRgb(0, 158, 115)));
  // The legend has the visible series only. In the window there is none.
  click("series_1");
  wait(200);
  const QImage without_one = saved();
  EXPECT_TRUE(in_legend(without_one, qRgb(0, 158, 115)));
  EXPECT_FALSE(in_legend(without_one, qRgb(230, 159, 0)));
  click("series_1");
  wait(300);
  EXPECT_EQ(differing_pixels(window_->chart()->canvas()->grab().toImage(), shown), 0);
}

}  // namespace
}  // namespace tetraction::viewer
