// The tree of the scene and the inspector, as a person uses them.
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QScrollArea>
#include <QTemporaryDir>
#include <QTimer>

#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/widgets/vector_fields.h"
#include "viewer/history_log.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Tree : public WindowTest {
 protected:
  SceneTree* tree() { return window_->scene_panels()->tree(); }

  void click_item(QTreeWidgetItem* item, int column) {
    ASSERT_NE(item, nullptr);
    tree()->scrollToItem(item);
    const QRect rect = tree()->visualItemRect(item);
    const int x = column == 0 ? rect.left() + 20
                              : tree()->columnViewportPosition(1) + tree()->columnWidth(1) / 2;
    QTest::mouseClick(tree()->viewport(), Qt::LeftButton, Qt::NoModifier,
                      QPoint(x, rect.center().y()));
    settle();
  }
  void add(const std::string& section) { click_item(tree()->group_of(section), 1); }
  int count(const std::string& section) { return tree()->group_of(section)->childCount(); }
  void press_in_tree(int key) {
    QTest::keyClick(tree(), static_cast<Qt::Key>(key));
    settle();
  }
  // Chooses from the menu of an item.
  void choose_from_menu(QTreeWidgetItem* item, const QString& text) {
    ASSERT_NE(item, nullptr);
    tree()->scrollToItem(item);
    QTimer::singleShot(200, [&] {
      auto* menu = qobject_cast<QMenu*>(QApplication::activePopupWidget());
      ASSERT_NE(menu, nullptr);
      for (QAction* action : menu->actions()) {
        if (action->text() == text) menu->setActiveAction(action);
      }
      QTest::keyClick(menu, Qt::Key_Return);
    });
    QContextMenuEvent event(QContextMenuEvent::Mouse, tree()->visualItemRect(item).center());
    QCoreApplication::sendEvent(tree()->viewport(), &event);
    settle();
  }
  // The saved scene, run from its file, gives the history of the window.
  void expect_same_when_run() {
    for (int i = 0; i < 3; ++i) window_->simulation()->step();
    settle();
    const QTemporaryDir folder;
    const QString path = folder.filePath(QStringLiteral("saved.toml"));
    ASSERT_TRUE(window_->save_scene(path));
    const Scene scene = read_scene(path.toStdString());
    Session session(scene, read_scene_mesh(scene));
    const std::vector<HistoryRow> rows = window_->simulation()->history(0);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      ASSERT_TRUE(session.step()) << session.message();
      const HistoryRow row = history_row(session);
      EXPECT_EQ(row.time, rows[i].time);
      EXPECT_EQ(row.total, rows[i].total);
      EXPECT_EQ(row.linear_momentum, rows[i].linear_momentum);
    }
  }
};

TEST_F(Tree, EntriesOfEveryListAreMadeSwitchedAndDeleted) {
  for (const OutlineGroup& group : outline(Json::object())) {
    if (!group.is_list) continue;
    SCOPED_TRACE(group.section);
    show(quiet_beam());
    settle();
    // Two vertices for a constraint of their distance.
    if (group.section == "constraint") {
      window_->select({nearest({1.2, 0.0, 0.0}), nearest({1.2, 0.3, 0.3})});
      wait(300);
    }
    const int before = count(group.section);
    add(group.section);
    ASSERT_EQ(count(group.section), before + 1) << message().toStdString();
    const EntryPlace place{group.section, static_cast<std::size_t>(before)};
    EXPECT_EQ(tree()->chosen(), place);
    EXPECT_TRUE(
        find<QLabel>("entry_title")->text().startsWith(QString::fromStdString(group.title)));
    EXPECT_GE(find<QDockWidget>("dock_inspector")->findChildren<QLineEdit*>().size() +
                  find<QDockWidget>("dock_inspector")->findChildren<QComboBox*>().size(),
              1);
    click_item(tree()->item_of(place), 1);
    EXPECT_EQ(count(group.section), before + 1) << "it is off, but there";
    EXPECT_EQ(tree()->item_of(place), nullptr);
    click_item(tree()->group_of(group.section)->child(before), 1);
    ASSERT_NE(tree()->item_of(place), nullptr);
    expect_same_when_run();
    click_item(tree()->item_of(place), 0);
    press_in_tree(Qt::Key_Delete);
    EXPECT_EQ(count(group.section), before);
    window_->simulation()->undo();
    settle();
    EXPECT_EQ(count(group.section), before + 1);
    window_->simulation()->reset();
    settle();
  }
}

TEST_F(Tree, EverySectionHasFieldsThatFitTheWindow) {
  window_->resize(1024, 700);
  show(first_scene());
  for (const OutlineGroup& group : outline(Json::object())) {
    if (group.is_list) continue;
    show_entry(group.section);
    auto* scroll = find<QDockWidget>("dock_inspector")->findChild<QScrollArea*>();
    EXPECT_LE(scroll->widget()->minimumSizeHint().width(), scroll->viewport()->width())
        << group.section;
    for (QLineEdit* field : scroll->findChildren<QLineEdit*>()) {
      EXPECT_GE(field->width(), 40) << group.section << " " << field->objectName().toStdString();
    }
    keep_picture(("inspector_" + group.section).c_str());
  }
}

TEST_F(Tree, WhatADeletionMeansForEventsIsTold) {
  Document document = quiet_beam();
  FixSettings moved = document.scene.fix[0];
  moved.offset = Vector3(0.0, 0.01, 0.0);
  EventSettings event;
  event.at = 0.5;
  event.edits = {SetFix{0, moved}};
  document.scene.event = {event};
  show(std::move(document));
  show_entry("fix");
  QTest::keyClick(window_->scene_panels()->tree(), Qt::Key_Delete);
  settle();
  EXPECT_EQ(window_->scene_panels()->tree()->item_of({"fix", 0}), nullptr);
  expect_told(QStringLiteral("what the event at 0.5 s would change"));
  window_->simulation()->undo();
  settle();
  EXPECT_NE(window_->scene_panels()->tree()->item_of({"fix", 0}), nullptr);
}

TEST_F(Tree, SelectedVerticesThatAreNoBodyAreToldToANewBodyForce) {
  show(quiet_beam());
  window_->select({nearest(Vector3(1.2, 0.3, 0.3))});
  settle();
  emit window_->scene_panels()->tree()->add_wanted(QStringLiteral("body_force"));
  settle();
  ASSERT_TRUE(wait_for(
      [this] {
        return window_->scene_panels()->tree()->item_of({"body_force", 0}) != nullptr;
      },
      5000));
  expect_told(QStringLiteral("the whole body"));
}

TEST_F(Tree, AChangeOfTheSceneSetsTheRunUpAgain) {
  show(quiet_beam());
  press_and_settle(Qt::Key_S);
  show_entry("material");
  enter("density", "500");
  EXPECT_EQ(state().step, 0);
  EXPECT_NEAR(window_->simulation()->settings().mean_density, 500.0, 1e-9);
  expect_told(QStringLiteral("Set up again: Density 500"));
  EXPECT_TRUE(
      menu_action(QStringLiteral("&Undo"))->text().contains(QStringLiteral("Set up again")));
  expect_same_when_run();
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_NEAR(window_->simulation()->settings().mean_density, 1000.0, 1e-9);
}

TEST_F(Tree, AnotherMeshIsDrawn) {
  show(quiet_beam());
  const Index before = window_->simulation()->mesh().vertex_count();
  show_entry("mesh");
  auto* cells = find<QLineEdit>("cells");
  cells->setFocus();
  cells->selectAll();
  QTest::keyClicks(cells, "4, 2, 2");
  QTest::keyClick(cells, Qt::Key_Return);
  settle();
  EXPECT_LT(window_->simulation()->mesh().vertex_count(), before);
  ASSERT_NE(window_->body_view()->state(), nullptr);
  EXPECT_EQ(window_->body_view()->state()->position.size(),
            3 * window_->simulation()->mesh().vertex_count());
  press_and_settle(Qt::Key_S);
  EXPECT_EQ(state().step, 1);
  keep_picture("other_mesh");
  cells = find<QLineEdit>("cells");
  cells->setFocus();
  cells->selectAll();
  QTest::keyClicks(cells, "4, -2, 2");
  QTest::keyClick(cells, Qt::Key_Return);
  settle();
  EXPECT_TRUE(reason("cells").contains(QStringLiteral("1 or more")))
      << reason("cells").toStdString();
  EXPECT_EQ(cells->text(), QStringLiteral("4, -2, 2"));
  EXPECT_EQ(state().step, 1);
}

TEST_F(Tree, NamesAreChangedInPlace) {
  show(quiet_beam());
  settle();
  add("amplitude");
  QTreeWidgetItem* item = tree()->item_of({"amplitude", 0});
  ASSERT_NE(item, nullptr);
  EXPECT_EQ(item->text(0), QStringLiteral("amplitude_1"));
  press_in_tree(Qt::Key_F2);
  auto* editor = tree()->findChild<QLineEdit*>();
  ASSERT_NE(editor, nullptr);
  QTest::keyClicks(editor, "slow");
  QTest::keyClick(editor, Qt::Key_Return);
  settle();
  ASSERT_EQ(window_->simulation()->scene().amplitude.size(), 1U);
  EXPECT_EQ(window_->simulation()->scene().amplitude[0].name, "slow");
  choose_from_menu(tree()->item_of({"amplitude", 0}), QStringLiteral("Duplicate"));
  ASSERT_EQ(window_->simulation()->scene().amplitude.size(), 2U);
  EXPECT_EQ(window_->simulation()->scene().amplitude[1].name, "slow_1");
  choose_from_menu(tree()->item_of({"amplitude", 1}), QStringLiteral("Delete"));
  EXPECT_EQ(window_->simulation()->scene().amplitude.size(), 1U);
}

// The vertices of this file count from 1.
TEST_F(Tree, AConstraintIsMadeWithoutASelection) {
  open(QStringLiteral(TETRACTION_DATA "/tuning_fork.msh"));
  ASSERT_NE(window_->simulation(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(window_->simulation()->mesh().vertex_id(0), 1);
  window_->messages()->clear();
  add("constraint");
  EXPECT_EQ(message(), QString());
  EXPECT_EQ(count("constraint"), 1);
}

TEST_F(Tree, ValuesThatAreNotThereAreEmptyFields) {
  Document document = quiet_beam();
  document.scene.time.end = std::numeric_limits<double>::infinity();
  show(std::move(document));
  show_entry("fix");
  EXPECT_EQ(number_field("target", 1)->text(), QString());
  EXPECT_EQ(number_field("velocity", 1)->text(), QStringLiteral("0"));
  enter("offset", "0.001", 1);
  ASSERT_TRUE(window_->simulation()->settings().fixes[0].offset);
  EXPECT_EQ(*window_->simulation()->settings().fixes[0].offset, Vector3(0.0, 0.001, 0.0));
  EXPECT_EQ(number_field("offset", 0)->text(), QStringLiteral("0"));
  // A click leads into an empty field.
  show_entry("time");
  NumberField* end = number_field("end");
  ASSERT_EQ(end->text(), QString());
  QTest::mouseClick(end, Qt::LeftButton);
  EXPECT_TRUE(end->hasFocus());
}

TEST_F(Tree, ASelectionTakesTheSelectedVertices) {
  show(quiet_beam());
  settle();
  const Index tip = nearest({1.2, 0.3, 0.3});
  add("force");
  EXPECT_TRUE(
      std::holds_alternative<SelectAll>(window_->simulation()->settings().loads.force[0].select));
  window_->select({tip});
  wait(400);
  push("use_selected");
  const auto loads = window_->simulation()->settings().loads;
  ASSERT_TRUE(std::holds_alternative<SelectVertices>(loads.force[0].select));
  EXPECT_EQ(std::get<SelectVertices>(loads.force[0].select).ids,
            std::vector<std::int64_t>{window_->simulation()->mesh().vertex_id(tip)});
  enter("vector", "-2", 1);
  EXPECT_EQ(vertex_block(state().external_force, tip), Vector3(0.0, -2.0, 0.0));
  auto* kind = find<QComboBox>("selection_kind");
  kind->setFocus();
  kind->setCurrentIndex(kind->findData(QStringLiteral("plane")));
  QTest::keyClick(kind, Qt::Key_Up);
  QTest::keyClick(kind, Qt::Key_Down);
  settle();
  enter("at", "1.2");
  const auto now = window_->simulation()->settings().loads;
  ASSERT_TRUE(std::holds_alternative<SelectPlane>(now.force[0].select));
  EXPECT_EQ(std::get<SelectPlane>(now.force[0].select).at, 1.2);
  keep_picture("force");
}

}  // namespace
}  // namespace tetraction::viewer
