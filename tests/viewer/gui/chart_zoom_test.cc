// The user's own zoom of a chart: with the mouse, and it stays while the run goes on.
#include <QWheelEvent>

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
