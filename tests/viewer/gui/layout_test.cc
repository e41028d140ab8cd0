// Panels, charts and the picture at the sizes of real screens.
#include <QComboBox>
#include <QDir>
#include <QDockWidget>
#include <QHeaderView>
#include <QScreen>
#include <QScrollArea>
#include <QScrollBar>
#include <QTabBar>
#include <QTemporaryDir>
#include <QToolButton>

#include "tetraction/io/run_recorder.h"
#include "viewer/gui/replay/replay.h"
#include "viewer/gui/transport/transport_bar.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Layout : public WindowTest {
 protected:
  // Whether the whole panel is inside its area, or a scroll bar leads to the rest.
  static void expect_reachable(QScrollArea* area) {
    const bool fits = area->widget()->width() <= area->viewport()->width();
    EXPECT_TRUE(fits || area->horizontalScrollBar()->maximum() > 0);
    EXPECT_TRUE(area->widget()->height() <= area->viewport()->height() ||
                area->verticalScrollBar()->maximum() > 0);
  }
};

// z of the load and the damping lay outside the panel, without a scroll bar.
TEST_F(Layout, EveryFieldOfAPanelCanBeReached) {
  open(QStringLiteral(TETRACTION_DATA "/../examples/scenes/rubber_band.toml"));
  ASSERT_NE(window_->simulation(), nullptr) << window_->messages()->text().toStdString();
  auto* area = find<QDockWidget>("dock_inspector")->findChild<QScrollArea*>();
  for (const char* section : {"force", "damping"}) {
    show_entry(section);
    settle();
    expect_reachable(area);
    EXPECT_GE(area->findChildren<NumberField*>().size(), 3);
    for (NumberField* field : area->findChildren<NumberField*>()) {
      if (!field->isVisible()) continue;
      const int right = field->mapTo(area->widget(), QPoint(field->width(), 0)).x();
      EXPECT_LE(right, area->viewport()->width() + area->horizontalScrollBar()->maximum())
          << field->what().toStdString();
    }
    keep_picture((std::string("rubber_band_") + section).c_str());
  }
}

TEST_F(Layout, TheWindowFitsTheScreen) {
  window_.reset();
  QSettings().clear();
  open_window(false);
  const QSize screen = QGuiApplication::primaryScreen()->availableSize();
  EXPECT_LE(window_->width(), screen.width());
  EXPECT_LE(window_->height(), screen.height());
  // And a small one: the panels give way, not the screen.
  EXPECT_LE(window_->minimumSizeHint().width(), 1024);
  EXPECT_LE(window_->minimumSizeHint().height(), 700);
}

// At this size the title of a group was cut, the tabs of the charts had to be scrolled, and a replay made the window
// wider than the screen.
TEST_F(Layout, ASmallWindowShowsTitlesAndTabsAndStaysSmall) {
  window_->resize(1024, 700);
  Document document = falling_beam();
  document.scene.probe.emplace_back();
  document.scene.probe.back().name = "tip";
  document.scene.probe.back().select = SelectPlane{0, 1.2, {}};
  show(document);
  auto* tree = window_->scene_panels()->tree();
  for (int i = 0; i < tree->topLevelItemCount(); ++i) {
    const QRect item = tree->visualItemRect(tree->topLevelItem(i));
    const QString title = tree->topLevelItem(i)->text(0);
    EXPECT_LE(item.left() + tree->fontMetrics().horizontalAdvance(title),
              tree->header()->sectionSize(0))
        << title.toStdString();
  }
  auto* tabs = find<QTabBar>("chart_tabs");
  EXPECT_EQ(tabs->count(), 7);
  EXPECT_LE(tabs->tabRect(6).right(), tabs->width());
  EXPECT_EQ(window_->width(), 1024) << "a scene";
  keep_picture("small_scene");
  run_to(0.05);
  window_->transport()->go_to(0.02);
  settle();
  EXPECT_TRUE(find<QToolButton>("continue_here")->isVisible());
  EXPECT_EQ(window_->width(), 1024) << "an earlier state is shown";
  keep_picture("small_earlier_state");

  const QTemporaryDir folder;
  document.scene.time.end = 0.1;
  Session session(document.scene, document.mesh);
  RunRecorder recorder(folder.filePath(QStringLiteral("run")).toStdString(), 10);
  session.run({&recorder});
  open(folder.filePath(QStringLiteral("run")));
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  wait();
  EXPECT_EQ(window_->width(), 1024) << "a replay";
  EXPECT_LE(tabs->tabRect(6).right(), tabs->width());
  QStringList texts;
  for (const QLabel* text : window_->findChildren<QLabel*>(QStringLiteral("replay_text"))) {
    texts += text->text();
  }
  EXPECT_EQ(texts.size(), 2);
  EXPECT_EQ(texts.removeDuplicates(), 0);
  keep_picture("small_replay");
}

TEST_F(Layout, APanelThatComesBackLiesAboveTheOthers) {
  show(quiet_beam());
  auto* dock = find<QDockWidget>("dock_drawing");
  raise("dock_drawing");
  dock->setFloating(true);
  wait();
  dock->setFloating(false);
  wait();
  EXPECT_FALSE(dock->visibleRegion().isEmpty());
}

TEST_F(Layout, ChartAxesHaveTwoTicksOrMore) {
  show(falling_beam());
  run_to(0.05);
  for (int kind = 0; kind < 4; ++kind) {
    window_->chart()->show_kind(kind);
    wait();
    const auto ticks = window_->chart()->ticks();
    EXPECT_GE(ticks[0].size(), 2U) << kind;
    EXPECT_GE(ticks[1].size(), 2U) << kind;
  }
}

TEST_F(Layout, TheColourBarHasAPlaceOfItsOwn) {
  show(quiet_beam());
  BodyView* view = window_->body_view();
  DrawingSettings drawing = view->drawing();
  drawing.field = nullptr;
  view->set_drawing(drawing);
  press_key(Qt::Key_Z);
  wait();
  const int without = place_of(nearest({1.2, 0.3, 0.3})).x();
  drawing.field = find_quantity("displacement");
  view->set_drawing(drawing);
  wait();
  const int with = place_of(nearest({1.2, 0.3, 0.3})).x();
  EXPECT_LT(with, without) << "the body moves aside";
  EXPECT_LT(with, view->canvas()->width() - 120);
  keep_picture("gutter");
}

TEST_F(Layout, ColoursForgetTheRangeOfTheRunBefore) {
  show(falling_beam());
  run_to(0.2);
  const double before = window_->body_view()->color_high();
  press_and_settle(Qt::Key_R);
  EXPECT_LT(window_->body_view()->color_high(), 1e-2 * before);
}

// Pulling an arrow on a body under pressure saved the opposite of the pressure.
TEST_F(Layout, TheUsersForceIsApartFromOtherLoads) {
  Document document = quiet_beam();
  ForceSettings pressure;
  pressure.kind = LoadKind::kPressure;
  pressure.select = SelectSurface{};
  pressure.value = 1000.0;
  document.scene.pressure.push_back(pressure);
  show(std::move(document));
  const Index tip = nearest({1.2, 0.3, 0.3});
  ASSERT_GT(vertex_block(state().external_force, tip).norm(), 0.0);
  window_->select({tip});
  raise("dock_vertices");
  EXPECT_EQ(find<NumberField>("force_x")->value(), 0.0);
  trigger("tool_4");
  drag(place_of(tip), place_of(tip) + QPoint(0, -60));
  settle();
  const auto& forces = window_->simulation()->settings().loads.force;
  ASSERT_EQ(forces.size(), 1U);
  EXPECT_EQ(forces[0].vector, Vector3(vertex_block(state().user_force, tip)));
  EXPECT_GT(forces[0].vector.y(), 0.0);
}

TEST_F(Layout, ADragOnTheStepIsFine) {
  show(quiet_beam());
  show_entry("time");
  NumberField* step = number_field("step");
  const double before = step->value();
  drag(step, QPoint(10, 8), QPoint(39, 8));
  settle();
  EXPECT_GT(step->value(), 2.0 * before);
  EXPECT_LT(step->value(), 4.0 * before);
}

TEST_F(Layout, TheSelectionsTextMovesNoField) {
  show(quiet_beam());
  raise("dock_vertices");
  auto* field = find<NumberField>("position_x");
  const int none = field->mapTo(window_.get(), QPoint()).y();
  window_->select({5});
  wait();
  EXPECT_EQ(field->mapTo(window_.get(), QPoint()).y(), none);
  window_->select({5, 6, 7});
  wait();
  EXPECT_EQ(field->mapTo(window_.get(), QPoint()).y(), none);
}

TEST_F(Layout, EdgesOfADenseMeshFade) {
  BodyView* view = window_->body_view();
  const auto dark_share = [&](int cells) {
    Document document = quiet_beam();
    document.scene.mesh.generate =
        GeneratorSettings{GeneratorKind::kBox, {0.3, 0.3, 0.3}, {cells, cells, cells}};
    document.mesh = mesh_of(document.scene);
    document.scene.fix.clear();
    show(std::move(document));
    DrawingSettings drawing = view->drawing();
    drawing.field = nullptr;
    view->set_drawing(drawing);
    wait();
    const QImage picture = view->picture();
    int dark = 0;
    int body = 0;
    for (int y = 0; y < picture.height(); y += 2) {
      for (int x = 0; x < picture.width(); x += 2) {
        const QColor color = picture.pixelColor(x, y);
        if (color.blue() > color.red() + 12 || color.lightness() > 200) continue;
        ++body;
        dark += color.lightness() < 90 ? 1 : 0;
      }
    }
    return static_cast<double>(dark) / std::max(body, 1);
  };
  const double coarse = dark_share(4);
  const double dense = dark_share(30);
  EXPECT_LT(dense, std::max(coarse, 0.02)) << "the edges would cover nearly everything";
}

TEST_F(Layout, AReplayHasASpeedALoopAndAChartToClick) {
  QTemporaryDir folder;
  show(falling_beam());
  window_->record_run(folder.filePath(QStringLiteral("run")), 2);
  EXPECT_TRUE(find<QLabel>("recording_sign")->isVisible());
  run_to(0.2);
  window_->stop_recording();
  EXPECT_FALSE(find<QLabel>("recording_sign")->isVisible());
  settle();
  open(folder.filePath(QStringLiteral("run")));
  ASSERT_NE(window_->replay(), nullptr);
  EXPECT_FALSE(find<QAction>("tool_3")->isVisible()) << "nothing can be dragged";
  TransportBar* bar = window_->transport();
  bar->go_to(window_->replay()->times().back());
  QWidget* chart = window_->chart()->canvas();
  const double end = window_->replay()->times().back();
  ASSERT_TRUE(wait_for([&] { return window_->chart()->axis_ranges()[1] >= 0.99 * end; }));
  wait();
  QTest::mouseClick(chart, Qt::LeftButton, Qt::NoModifier,
                    QPoint(chart->width() / 2, chart->height() / 2));
  EXPECT_TRUE(wait_for([&] { return window_->body_view()->state()->time < 0.18; }));
  EXPECT_GT(window_->body_view()->state()->time, 0.02);
  auto* speed = find<QComboBox>("speed");
  speed->setCurrentIndex(speed->count() - 1);
  click("replay_loop");
  bar->play(true);
  bool wrapped = false;
  std::size_t last = bar->frame();
  ASSERT_TRUE(wait_for([&] {
    wrapped = wrapped || bar->frame() < last;
    last = bar->frame();
    return wrapped;
  }));
  EXPECT_TRUE(bar->playing());
}

TEST_F(Layout, ThePictureHasMostOfTheWidth) {
  show(quiet_beam());
  QString widths;
  for (QDockWidget* dock : window_->findChildren<QDockWidget*>()) {
    widths +=
        QStringLiteral(" %1 %2,").arg(dock->objectName()).arg(dock->minimumSizeHint().width());
  }
  const int before = window_->body_view()->width();
  EXPECT_GE(before, 0.6 * window_->width()) << widths.toStdString();
  // It stays where it is under the mouse, whatever the panels tell.
  for (const Vector3& place : {Vector3(1.2, 0.3, 0.3), Vector3(0.0, 0.3, 0.3)}) {
    window_->select({nearest(place)});
    settle();
    EXPECT_EQ(window_->body_view()->width(), before);
  }
}

TEST_F(Layout, PicturesAreEquallySpacedInSimulatedTime) {
  QTemporaryDir folder;
  show(falling_beam());
  std::vector<double> times;
  window_->record_pictures(folder.filePath(QStringLiteral("film")));
  EXPECT_TRUE(find<QLabel>("recording_sign")->isVisible());
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().time > 0.6; }));
  window_->simulation()->pause();
  settle();
  const double end = state().time;
  window_->stop_recording();
  const int pictures = QDir(folder.filePath(QStringLiteral("film"))).entryList({"*.png"}).size();
  // The speed was 1 when the recording began: 25 pictures a second, the start included.
  EXPECT_NEAR(pictures, std::floor(end / 0.04) + 1, 1);
}

}  // namespace
}  // namespace tetraction::viewer
