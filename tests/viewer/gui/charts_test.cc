// Charts: rows, marks, series, zoom, files.
#include <QCheckBox>
#include <QFile>
#include <QTabBar>
#include <QTemporaryDir>

#include <algorithm>

#include "viewer/gui/chart_series.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Charts : public WindowTest {
 protected:
  void run_to(double time) {
    window_->simulation()->set_speed_limit(0.0);
    window_->simulation()->run();
    ASSERT_TRUE(wait_for([&] { return state().time > time; }));
    window_->simulation()->pause();
    settle();
  }
};

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

}  // namespace
}  // namespace tetraction::viewer
