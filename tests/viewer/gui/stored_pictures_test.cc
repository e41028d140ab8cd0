// What the view and the charts draw, against stored pictures.
#include "stored_pictures.h"

#include <cmath>

#include "window_test.h"

namespace tetraction::viewer {
namespace {

constexpr double kThreshold = 8.0;  // the mesh's edges alone make 30

// The parts of the window alone, so that sizes do not depend on the fonts of the machine.
class StoredPictures : public testing::Test {
 protected:
  void show(QWidget& widget, int width, int height) {
    widget.resize(width, height);
    widget.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&widget));
  }

  // The beam as it bends under its weight, after some steps.
  void bend(BodyView& view, ColorField field, int steps = 30) {
    Document document = first_scene();
    document.scene.mesh.generate =
        GeneratorSettings{GeneratorKind::kBox, {1.2, 0.3, 0.3}, {8, 2, 2}};
    document.mesh = generate_mesh(*document.scene.mesh.generate);
    simulation_ = std::make_unique<Simulation>(document.scene, document.mesh);
    simulation_->set_color_field(field);
    for (int i = 0; i < steps; ++i) simulation_->step();
    ASSERT_TRUE(simulation_->wait_until_idle(30.0));
    view.set_body(make_body_shape(simulation_->mesh()));
    view.show_state(simulation_->snapshot());
  }

  std::unique_ptr<Simulation> simulation_;
};

TEST_F(StoredPictures, ViewOfABentBeam) {
  BodyView view;
  show(view, 640, 480);
  bend(view, find_quantity("von_mises"));
  view.render();
  expect_as_stored(view.picture(), "von_mises", kThreshold);

  // Something else is noticed.
  DrawingSettings drawing;
  drawing.edges = false;
  view.set_drawing(drawing);
  EXPECT_GT(difference_to_stored(view.picture(), "von_mises"), 3.0 * kThreshold);
}

TEST_F(StoredPictures, ClipPlaneAndVolumeRatio) {
  BodyView view;
  show(view, 640, 480);
  bend(view, find_quantity("jacobian"));
  DrawingSettings drawing;
  drawing.field = find_quantity("jacobian");
  drawing.clip = true;
  drawing.clip_axis = 2;
  drawing.clip_at = 0.6;
  view.set_drawing(drawing);
  expect_as_stored(view.picture(), "clip", kThreshold);
}

TEST_F(StoredPictures, PointsRestShapeAxesAndArrowsOnADarkBackground) {
  BodyView view;
  show(view, 640, 480);
  bend(view, find_quantity("displacement"));
  DrawingSettings drawing;
  drawing.field = find_quantity("displacement");
  drawing.surface = drawing.edges = false;
  drawing.points = drawing.rest = drawing.axes = drawing.momenta = drawing.reactions = true;
  drawing.background = Background::kDark;
  view.set_drawing(drawing);
  expect_as_stored(view.picture(), "points", kThreshold);
}

TEST_F(StoredPictures, SelectionAndAttraction) {
  BodyView view;
  show(view, 640, 480);
  bend(view, nullptr, 0);
  view.set_attraction(true);
  DrawingSettings drawing;
  drawing.field = nullptr;
  drawing.light_azimuth = 60.0;
  view.set_drawing(drawing);
  view.set_selection({8, 17, 26, 80});
  expect_as_stored(view.picture(), "selection", kThreshold);
}

TEST_F(StoredPictures, ChartWithMarksAndCursor) {
  LiveChart chart;
  show(chart, 640, 260);
  std::vector<HistoryRow> rows(400);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    HistoryRow& row = rows[i];
    row.time = 0.005 * static_cast<double>(i);
    row.kinetic = 3.0 * std::pow(std::sin(4.0 * row.time), 2.0);
    row.elastic = 3.0 - row.kinetic;
    row.environment = -std::sin(row.time);
    row.total = row.kinetic + row.elastic + row.environment;
  }
  chart.append(rows);
  chart.set_marks({{0.4, "Young's modulus 2 MPa"}, {1.3, "Step 0.001 s"}});
  chart.set_cursor(1.6);
  chart.refresh();
  // Only what VTK draws: the rest has the fonts of the machine, and its width depends on them.
  chart.canvas()->setFixedSize(480, 200);
  QTest::qWait(200);
  chart.set_cursor(1.7);
  chart.refresh();
  expect_as_stored(chart.canvas()->grab().toImage(), "chart", kThreshold);
}

// The whole window, so coarsely that other fonts do not matter, but a panel that is missing does.
class StoredWindow : public WindowTest {};

TEST_F(StoredWindow, AtItsStart) {
  show(first_scene());
  wait(300);
  const auto coarse = [&] {
    return window_->grab().toImage().scaled(160, 100, Qt::IgnoreAspectRatio,
                                            Qt::SmoothTransformation);
  };
  constexpr double kCoarse = 3.0;  // the type face is the same everywhere
  expect_as_stored(coarse(), "window", kCoarse);
  window_->findChild<QWidget*>(QStringLiteral("dock_charts"))->hide();
  wait(300);
  EXPECT_GT(difference_to_stored(coarse(), "window"), 3.0 * kCoarse);
}

}  // namespace
}  // namespace tetraction::viewer
