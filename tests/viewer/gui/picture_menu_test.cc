// The menu of the picture: names and probes for what is selected there.
#include <QComboBox>
#include <QMenu>
#include <QTabBar>
#include <QTemporaryDir>

#include "dialogs.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class PictureMenu : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    show(quiet_beam());
    settle();
    tip_ = nearest({1.2, 0.3, 0.3});
  }
  void right_click(const QPoint& place) {
    QTest::mouseClick(window_->body_view()->canvas(), Qt::RightButton, Qt::NoModifier, place);
    wait(50);
  }
  void give_name(const QString& name) {
    const DialogAnswer answer([&](QDialog& dialog) {
      dialog.findChild<QLineEdit*>()->setText(name);
      dialog.accept();
    });
    press_and_settle(Qt::Key_N);
    EXPECT_TRUE(answer.given());
    EXPECT_FALSE(answer.stuck());
  }
  Index tip_ = 0;
};

TEST_F(PictureMenu, ARightClickSelectsTheVertexAndADragDoesNot) {
  auto* menu = find<QMenu>("picture_menu");
  right_click(place_of(tip_));
  EXPECT_TRUE(menu->isVisible());
  EXPECT_EQ(window_->selection(), std::vector<Index>{tip_});
  QStringList texts;
  for (const QAction* action : menu->actions()) texts += action->text();
  EXPECT_TRUE(texts.contains(QStringLiteral("&Probe selection")));
  EXPECT_TRUE(texts.contains(QStringLiteral("&Name selection…")));
  keep_picture("picture_menu");
  menu->close();
  // What is selected already stays selected.
  window_->select({0, tip_});
  right_click(place_of(tip_));
  EXPECT_EQ(window_->selection().size(), 2U);
  menu->close();
  QWidget* canvas = window_->body_view()->canvas();
  QTest::mousePress(canvas, Qt::RightButton, Qt::NoModifier, place_of(tip_));
  QTest::mouseMove(canvas, place_of(tip_) + QPoint(0, 40));
  QTest::mouseRelease(canvas, Qt::RightButton, Qt::NoModifier, place_of(tip_) + QPoint(0, 40));
  EXPECT_FALSE(menu->isVisible());
}

TEST_F(PictureMenu, ALoadUsesANamedSelectionAndTheRunGoesOn) {
  press_and_settle(Qt::Key_S);
  EXPECT_FALSE(find<QPushButton>("name_selection")->isEnabled());
  window_->select({tip_});
  EXPECT_TRUE(find<QPushButton>("name_selection")->isEnabled());
  give_name(QStringLiteral("corner"));
  EXPECT_EQ(state().step, 1);
  const SceneTree* tree = window_->scene_panels()->tree();
  ASSERT_TRUE(wait_for([&] { return tree->item_of({"selection", 0}) != nullptr; }, 3000));
  EXPECT_EQ(tree->item_of({"selection", 0})->text(0), QStringLiteral("corner"));
  EXPECT_EQ(tree->chosen(), (EntryPlace{"selection", 0}));

  window_->select({});
  window_->scene_panels()->add(QStringLiteral("force"), {});
  settle();
  show_entry("force");
  auto* kind = find<QComboBox>("selection_kind");
  ASSERT_GE(kind->findText(QStringLiteral("corner")), 0);
  kind->setFocus();
  QTest::keyClick(kind, Qt::Key_Home);
  settle();
  enter("vector", "-2", 1);
  const auto forces = window_->simulation()->settings().loads.force;
  ASSERT_EQ(forces.size(), 1U);
  const auto* named = std::get_if<SelectNamed>(&forces[0].select);
  ASSERT_NE(named, nullptr);
  EXPECT_EQ(named->name, "corner");
  EXPECT_EQ(vertex_block(state().external_force, tip_), Vector3(0.0, -2.0, 0.0));
  EXPECT_EQ(state().step, 1);

  const QTemporaryDir folder;
  const QString path = folder.filePath(QStringLiteral("saved.toml"));
  ASSERT_TRUE(window_->save_scene(path));
  const Scene saved = read_scene(path.toStdString());
  ASSERT_EQ(saved.selection.size(), 1U);
  EXPECT_EQ(select_vertices(read_scene_mesh(saved), saved.selection[0].select),
            std::vector<Index>{tip_});
}

TEST_F(PictureMenu, AProbeOfAVertexHasACurve) {
  window_->select({tip_});
  press_and_settle(Qt::Key_P, Qt::ShiftModifier);
  const auto& probes = window_->simulation()->scene().probe;
  ASSERT_EQ(probes.size(), 1U);
  EXPECT_EQ(probes[0].quantity, ProbeQuantity::kDisplacement);
  EXPECT_EQ(select_vertices(window_->simulation()->mesh(), probes[0].select),
            std::vector<Index>{tip_});
  const auto* tabs = find<QTabBar>("chart_tabs");
  EXPECT_TRUE(wait_for(
      [&] { return tabs->tabText(tabs->currentIndex()) == QStringLiteral("Probes"); }, 3000));
  MomentumSettings kick;
  kick.value = Vector3(0.0, 0.01, 0.0);
  make_edit(SetMomentum{kick}, "kick");
  press_and_settle(Qt::Key_S);
  ASSERT_TRUE(wait_for([&] { return window_->chart()->row_count() == 2; }, 3000));
  const Vector3 rest = window_->simulation()->mesh().vertices[static_cast<std::size_t>(tip_)];
  const std::vector<double>& last = window_->chart()->rows().back().probes;
  ASSERT_EQ(last.size(), 3U);
  EXPECT_NEAR(last[1], position(tip_).y() - rest.y(), 1e-12);
  EXPECT_GT(last[1], 0.0);
  keep_picture("probe_of_a_vertex");
}

}  // namespace
}  // namespace tetraction::viewer
