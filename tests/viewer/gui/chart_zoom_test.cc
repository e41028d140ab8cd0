// The user's own zoom of a chart: with the mouse, and it stays while the run goes on.
#include <QWheelEvent>
#include <cmath>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

using ChartZoom = WindowTest;

TEST_F(ChartZoom, DraggingZoomsAndWholeRunBringsAllBack) {
  show(first_scene());
  run_to(0.5);
  LiveChart* chart = window_->chart();
  const auto whole = chart->axis_ranges();
  EXPECT_EQ(whole[0], 0.0);
  EXPECT_DOUBLE_EQ(whole[1], state().time);
  const QSize size = chart->canvas()->size();
  const auto at = [&](double x, double y) {
    return QPointF(x * size.width(), y * size.height()).toPoint();
  };
  drag(chart->canvas(), at(0.4, 0.3), at(0.7, 0.6));
  const auto zoomed = chart->axis_ranges();
  EXPECT_GT(zoomed[0], whole[0] + 0.1 * whole[1]);
  EXPECT_LT(zoomed[1], 0.9 * whole[1]);
  EXPECT_GT(zoomed[2], whole[2]);
  EXPECT_LT(zoomed[3], whole[3]);
  EXPECT_GT(zoomed[3], zoomed[2]);
  keep_picture("chart_zoomed");
  run_to(0.8);
  EXPECT_EQ(chart->axis_ranges(), zoomed);
  click("whole_run");
  EXPECT_EQ(chart->axis_ranges()[0], 0.0);
  EXPECT_DOUBLE_EQ(chart->axis_ranges()[1], state().time);
  // And it follows the run again.
  run_to(1.0);
  EXPECT_DOUBLE_EQ(chart->axis_ranges()[1], state().time);
}

// VTK looks without end for the ticks of an axis whose ends are nearly the same number.
TEST_F(ChartZoom, EndsWhereNumbersAreTheSame) {
  show(first_scene());
  run_to(0.3);
  LiveChart* chart = window_->chart();
  const QPoint middle = chart->canvas()->rect().center();
  for (int i = 0; i < 15; ++i) drag(chart->canvas(), middle, middle + QPoint(6, 6));
  const auto zoomed = chart->axis_ranges();
  EXPECT_GT(zoomed[1], zoomed[0]);
  EXPECT_GT(zoomed[3], zoomed[2]);
  EXPECT_LT(zoomed[1] - zoomed[0], 1e-5);
  click("whole_run");
  EXPECT_DOUBLE_EQ(chart->axis_ranges()[1], state().time);
  // A series that changes in its last digits only, alone.
  LiveChart alone;
  std::vector<HistoryRow> rows(50);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time = 0.1 * static_cast<double>(i);
    rows[i].kinetic = rows[i].elastic = rows[i].environment = rows[i].total =
        i % 2 == 0 ? 1e10 : 1e10 + 2e-6;
  }
  rows[7].total = 1e300;  // before a blow-up
  alone.append(rows);
  alone.resize(500, 300);
  alone.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&alone));
  alone.refresh();
  EXPECT_GT(alone.axis_ranges()[3] - alone.axis_ranges()[2], 1e8);
}

// The energies of a body of micrometres are far below the round-off of a metre's.
TEST_F(ChartZoom, EnergiesOfASmallBodyFillTheChart) {
  LiveChart small;
  small.set_body_size(3e-5);
  std::vector<HistoryRow> rows(50);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time = 1e-9 * static_cast<double>(i);
    rows[i].kinetic = rows[i].total = 1e-18 * std::sin(0.2 * static_cast<double>(i));
  }
  small.append(rows);
  small.resize(500, 300);
  small.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&small));
  small.refresh();
  EXPECT_LT(small.axis_ranges()[3] - small.axis_ranges()[2], 3e-18);
  EXPECT_GT(small.ticks()[1].size(), 2U);
  // Those of a large one are round-off.
  small.set_body_size(1.0);
  small.append({rows.front()});
  small.refresh();
  EXPECT_GT(small.axis_ranges()[3] - small.axis_ranges()[2], 1.0);
}

TEST_F(ChartZoom, TheWheelZooms) {
  show(first_scene());
  run_to(0.3);
  LiveChart* chart = window_->chart();
  const auto whole = chart->axis_ranges();
  const auto turn = [&](int angle) {
    const QPoint place = chart->canvas()->rect().center();
    QWheelEvent wheel(place, chart->canvas()->mapToGlobal(place), QPoint(), QPoint(0, angle),
                      Qt::NoButton, Qt::NoModifier, Qt::NoScrollPhase, false);
    QCoreApplication::sendEvent(chart->canvas(), &wheel);
    wait(50);
    const auto ranges = chart->axis_ranges();
    return ranges[1] - ranges[0];
  };
  const double width = whole[1] - whole[0];
  const double in = turn(120);
  EXPECT_LT(in, 0.99 * width);
  const auto zoomed = chart->axis_ranges();
  run_to(0.5);
  EXPECT_EQ(chart->axis_ranges(), zoomed);
  EXPECT_GT(turn(-120), 1.01 * in);
  click("whole_run");
  EXPECT_DOUBLE_EQ(chart->axis_ranges()[1], state().time);
}

}  // namespace
}  // namespace tetraction::viewer
