// Equilibria, natural modes and studies: from the menu to what is shown of them, and two runs side by side.
#include <QCheckBox>
#include <QComboBox>
#include <QFile>
#include <QLineEdit>
#include <QProcess>
#include <QScreen>
#include <QSpinBox>
#include <QTabWidget>
#include <QTableWidget>
#include <QTemporaryDir>
#include <cmath>

#include "dialogs.h"
#include "pictures.h"
#include "tetraction/io/scene_reader.h"
#include "viewer/gui/results/comparison.h"
#include "viewer/gui/results/computation.h"
#include "viewer/gui/results/results_panel.h"
#include "viewer/gui/transport/transport_bar.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Results : public WindowTest {
 protected:
  QString path(const char* name) const { return folder_.filePath(QLatin1String(name)); }
  /// Chooses the entry of the menu, and fills the dialog: the folder, then what `fill` does.
  void compute(
      const char* entry, const QString& folder,
      const std::function<void(QDialog&)>& fill = [](QDialog&) {}) {
    QAction* action = menu_action(QLatin1String(entry));
    window_->poll();
    ASSERT_TRUE(action->isEnabled()) << entry;
    const DialogAnswer answer([&](QDialog& dialog) {
      dialog.findChild<QLineEdit*>(QStringLiteral("computation_folder"))->setText(folder);
      fill(dialog);
      dialog.accept();
    });
    action->trigger();
    EXPECT_TRUE(answer.given());
  }
  void wait_for_result() {
    ASSERT_TRUE(wait_for([this] { return !computation()->is_running(); }));
    wait_until_opened();
    wait();
  }
  Computation* computation() { return window_->findChild<Computation*>(); }
  QTableWidget* table() { return find<QTableWidget>("results_table"); }
  /// Two rules with two steps each.
  static void fill_study(QDialog& dialog) {
    for (QCheckBox* check : dialog.findChildren<QCheckBox*>()) {
      const QString name = check->objectName();
      if (name.startsWith(QLatin1String("rule_"))) {
        check->setChecked(name == QLatin1String("rule_midpoint") ||
                          name == QLatin1String("rule_backward-euler"));
      }
    }
    dialog.findChild<QLineEdit*>(QStringLiteral("study_steps"))
        ->setText(QStringLiteral("1e-2, 2e-2"));
    dialog.findChild<QLineEdit*>(QStringLiteral("study_end"))->setText(QStringLiteral("0.1"));
  }
  /// The same from the command line, and for modes. Returns the folder.
  QString command(const QStringList& arguments) {
    const QString out = folder_.filePath(arguments.front());
    const QString scene = path("scene.toml");
    QFile file(scene);
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(R"([mesh]
generate = { kind = "box", size = [1, 0.3, 0.3], cells = [6, 2, 2] }
[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
[time]
step = 0.01
end = 0.1
[output]
every = 1
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
)");
    file.close();
    const QString program = QCoreApplication::applicationDirPath() + QStringLiteral("/tetraction");
    QProcess process;
    process.setProcessChannelMode(QProcess::MergedChannels);
    process.start(program, arguments + QStringList{scene, "--out=" + out});
    EXPECT_TRUE(process.waitForFinished(120000));
    EXPECT_EQ(process.exitCode(), 0) << process.readAll().toStdString();
    return out;
  }
  QString study() {
    return command({QStringLiteral("study"),
                    QStringLiteral("--integrators=midpoint,backward-euler"),
                    QStringLiteral("--steps=1e-2,2e-2"), QStringLiteral("--frames=all"),
                    QStringLiteral("--no-plots")});
  }
  QString modes() { return command({QStringLiteral("modes"), QStringLiteral("--count=4")}); }
  void select_rows(int first, int second) {
    table()->clearSelection();
    table()->setSelectionMode(QAbstractItemView::MultiSelection);
    table()->selectRow(first);
    table()->selectRow(second);
    table()->setSelectionMode(QAbstractItemView::ExtendedSelection);
  }
  void compare_rows(int first, int second) {
    select_rows(first, second);
    auto* button = find<QPushButton>("compare_runs");
    ASSERT_TRUE(button->isEnabled());
    button->click();
    wait_until_opened();
    wait(300);
  }
  static double largest(const Vector& displacement) {
    return displacement.reshaped(3, displacement.size() / 3).colwise().norm().maxCoeff();
  }

  QTemporaryDir folder_;
};

TEST_F(Results, AnEquilibriumIsComputedAndReplayed) {
  show(falling_beam());
  make_edit(SetMaterial{0, elastic(3.0e6, 0.4)}, "Stiffer");
  for (int i = 0; i < 3; ++i) press_and_settle(Qt::Key_S);
  const Snapshot before = state();
  const double speed = window_->transport()->speed();
  compute("&Equilibrium", path("static"));
  EXPECT_FALSE(menu_action(QStringLiteral("&Equilibrium"))->isEnabled());  // one at a time
  press_and_settle(Qt::Key_S);  // the window goes on meanwhile
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(window_->replay()->kind(), RunKind::kEquilibrium);
  EXPECT_EQ(window_->replay()->times().back(), 1.0);
  EXPECT_GE(window_->replay()->times().size(), 11U);
  EXPECT_EQ(window_->simulation(), nullptr);
  // What was computed has the edits from the start.
  const Scene scene = read_scene(path("static/scene_of_window.toml").toStdString());
  EXPECT_EQ(scene.material.youngs_modulus, 3.0e6);
  EXPECT_TRUE(scene.event.empty());
  // The simulation is as it was, and its edit is still not saved.
  EXPECT_NE(window_->transport()->speed(), speed);
  menu_action(QStringLiteral("&Back to the simulation"))->trigger();
  EXPECT_EQ(window_->transport()->speed(), speed);
  wait();
  ASSERT_NE(window_->simulation(), nullptr);
  EXPECT_EQ(window_->replay(), nullptr);
  EXPECT_EQ(state().step, before.step + 1);
  EXPECT_TRUE(window_->simulation()->edited_since(0));
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(before.step) + 2);
  press_and_settle(Qt::Key_S);
  EXPECT_EQ(state().step, before.step + 2);
}

// The equilibrium is not that of the body that the user sees, and the window did not say so.
TEST_F(Results, WarningsOfACommandAreTold) {
  Document document = falling_beam();
  EventSettings event;
  event.at = 0.5;
  event.edits.push_back(SetMaterial{0, elastic(3.0e6, 0.4)});
  document.scene.event.push_back(event);
  show(std::move(document));
  compute("&Equilibrium", path("static"));
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  expect_told(QStringLiteral("The equilibrium is that of the scene at t = 0: its 1 [[event]] is"));
}

// Something else is opened: edits of the simulation that was kept are asked for.
TEST_F(Results, EditsOfTheSimulationThatIsKeptAreNotLost) {
  show(falling_beam());
  make_edit(SetMaterial{0, elastic(3.0e6, 0.4)}, "Stiffer");
  compute("&Equilibrium", path("static"));
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr);
  {
    const DialogAnswer cancel([](QDialog& dialog) { dialog.reject(); });
    window_->open(path("other.toml"));
    EXPECT_TRUE(cancel.given());
  }
  EXPECT_FALSE(window_->opening());
  ASSERT_NE(window_->simulation(), nullptr);
  EXPECT_TRUE(window_->simulation()->edited_since(0));
  window_->close_without_question();
}

TEST_F(Results, AModeSwings) {
  show(falling_beam());
  compute("Natural &modes", path("modes"), [](QDialog& dialog) {
    dialog.findChild<QSpinBox*>(QStringLiteral("mode_count"))->setValue(4);
  });
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(window_->replay()->kind(), RunKind::kMode);
  ASSERT_EQ(table()->rowCount(), 4);
  EXPECT_TRUE(table()->isVisible());
  const StoredModes stored(path("modes").toStdString());
  EXPECT_NEAR(table()->item(1, 2)->text().toDouble(), stored.modes()[1].frequency,
              1e-4 * stored.modes()[1].frequency);
  // It plays, again and again, in about two seconds a period.
  EXPECT_TRUE(window_->transport()->playing());
  const auto phase = [&] { return window_->body_view()->state()->time; };
  EXPECT_TRUE(wait_for([&] { return phase() > 0.8; }, 10000));
  EXPECT_TRUE(wait_for([&] { return phase() < 0.5; }, 10000));
  EXPECT_TRUE(window_->transport()->playing());
  press_key(Qt::Key_Space);
  EXPECT_FALSE(window_->transport()->playing());
  // As far as the amplitude says, about the body at rest.
  window_->transport()->go_to(0.25);
  const Vector rest = stored.mesh().rest_positions();
  const auto moved = [&] { return Vector(window_->body_view()->state()->position - rest); };
  const double diagonal = stored.motion(0).diagonal;
  EXPECT_NEAR(largest(moved()), 0.1 * diagonal, 1e-9);
  find<QSpinBox>("mode_amplitude")->setValue(30);
  EXPECT_NEAR(largest(moved()), 0.3 * diagonal, 1e-9);
  EXPECT_NEAR((moved() - stored.motion(0).displacement(0.25) * 3.0).norm(), 0.0, 1e-9);
  // Coloured by the displacement, also those of another mode.
  EXPECT_EQ(window_->body_view()->state()->field_values.size(), stored.mesh().vertices.size());
  keep_picture("modes");
  table()->selectRow(2);
  EXPECT_TRUE(window_->transport()->playing());
  window_->transport()->play(false);
  window_->transport()->go_to(0.25);
  EXPECT_NEAR((moved() - stored.motion(2).displacement(0.25) * 3.0).norm(), 0.0, 1e-9);
  EXPECT_FALSE(menu_action(QStringLiteral("Compare &with"))->isEnabled());
  // Another document has its own colours, and no table.
  menu_action(QStringLiteral("&Back to the simulation"))->trigger();
  wait();
  EXPECT_EQ(find<QComboBox>("color_field")->currentText().left(9),
            QStringLiteral("von Mises").left(9));
  EXPECT_FALSE(window_->results()->isVisible());
}

TEST_F(Results, ModesAboutTheEquilibriumAreThoseOfIt) {
  show(falling_beam());
  compute("Natural &modes", path("modes"), [](QDialog& dialog) {
    dialog.findChild<QSpinBox*>(QStringLiteral("mode_count"))->setValue(2);
    dialog.findChild<QCheckBox*>(QStringLiteral("about_equilibrium"))->setChecked(true);
  });
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  window_->transport()->play(false);
  window_->transport()->go_to(0.0);
  const Vector moved =
      window_->body_view()->state()->position - window_->replay()->mesh().rest_positions();
  EXPECT_GT(largest(moved), 0.02);  // it hangs
}

TEST_F(Results, AStudyHasATableFromWhichRunsAreOpened) {
  show(falling_beam());
  compute("&Study", path("study"), fill_study);
  wait_for_result();
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  ASSERT_EQ(table()->rowCount(), 4);
  EXPECT_EQ(table()->item(0, 0)->text(), QStringLiteral("midpoint"));
  EXPECT_EQ(table()->horizontalHeaderItem(1)->text(), QStringLiteral("solver"));
  // Sorted by numbers, which are not in the order of their texts.
  const auto column = [&](const QString& head) {
    for (int c = 0; c < table()->columnCount(); ++c) {
      if (table()->horizontalHeaderItem(c)->text() == head) return c;
    }
    ADD_FAILURE() << head.toStdString();
    return 0;
  };
  const int energy = column(QStringLiteral("energy"));
  table()->sortItems(energy, Qt::AscendingOrder);
  for (int row = 1; row < 4; ++row) {
    EXPECT_LE(table()->item(row - 1, energy)->text().toDouble(),
              table()->item(row, energy)->text().toDouble());
  }
  EXPECT_EQ(table()->item(3, 0)->text(), QStringLiteral("backward-euler"));
  // The row that is the last one now.
  const QString step = table()->item(3, column(QStringLiteral("step [s]")))->text();
  keep_picture("study");
  const QPoint place = table()->visualItemRect(table()->item(3, 0)).center();
  QTest::mouseClick(table()->viewport(), Qt::LeftButton, Qt::NoModifier, place);
  QTest::mouseDClick(table()->viewport(), Qt::LeftButton, Qt::NoModifier, place);
  wait_until_opened();
  EXPECT_EQ(QString::fromStdString(window_->replay()->directory()),
            path("study") + QStringLiteral("/backward-euler-") + step);
  EXPECT_EQ(table()->rowCount(), 4);
  EXPECT_TRUE(window_->results()->isVisible());
  EXPECT_GT(window_->replay()->times().size(), 1U);
}

TEST_F(Results, TwoRunsAreComparedSideBySide) {
  open(study());
  wait();
  ASSERT_EQ(table()->rowCount(), 4);
  EXPECT_FALSE(find<QPushButton>("compare_runs")->isEnabled());
  compare_rows(0, 3);
  Comparison* comparison = window_->comparison();
  BodyView* first = window_->body_view();
  BodyView* second = comparison->second_view();
  ASSERT_NE(second, nullptr) << window_->messages()->text().toStdString();
  EXPECT_TRUE(second->isVisible());
  EXPECT_NEAR(first->width(), second->width(), 20);
  EXPECT_TRUE(find<QLabel>("first_run")->text().startsWith(QStringLiteral("midpoint-0.01")));
  EXPECT_TRUE(find<QLabel>("second_run")->text().startsWith(QStringLiteral("backward-euler-0.02")));
  // One time, of which the second run shows the nearest frame.
  window_->transport()->go_to(0.05);
  wait();
  EXPECT_NEAR(first->state()->time, 0.05, 1e-9);
  EXPECT_NEAR(second->state()->time, 0.05, 0.011);
  const auto own = Replay((path("study") + QStringLiteral("/backward-euler-0.02")).toStdString())
                       .frame(comparison->second()->frame_at(0.05), nullptr);
  EXPECT_EQ(second->state()->position, own->position);
  // One range of colours, which has the values of both.
  EXPECT_EQ(first->color_low(), second->color_low());
  EXPECT_EQ(first->color_high(), second->color_high());
  for (const BodyView* view : {first, second}) {
    for (const float value : view->state()->field_values) EXPECT_LE(value, first->color_high());
  }
  // One camera, whichever picture is turned. VTK normalises its directions once more.
  const auto same_camera = [&] {
    const auto a = first->camera();
    const auto b = second->camera();
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (std::abs(a[i] - b[i]) > 1e-12 * std::max(1.0, std::abs(a[i]))) return false;
    }
    return true;
  };
  const auto turn = [&](BodyView* view) {
    const auto before = view->camera();
    drag(view->canvas(), view->canvas()->rect().center(),
         view->canvas()->rect().center() + QPoint(60, 25));
    EXPECT_NE(view->camera(), before);
    EXPECT_TRUE(wait_for(same_camera, 5000));
  };
  turn(first);
  turn(second);
  press_key(Qt::Key_X);
  EXPECT_TRUE(wait_for(same_camera, 5000));
  EXPECT_FALSE(window_->chart()->other_rows().empty());
  press_key(Qt::Key_O);
  find<QDockWidget>("dock_charts")->findChild<QTabWidget*>()->setCurrentIndex(0);
  wait(300);
  // The chart was behind the table: what is on the screen now is no black rectangle.
  const QWidget* canvas = window_->chart()->canvas();
  const QPoint corner = canvas->mapToGlobal(QPoint(0, 0));
  const QImage chart =
      QGuiApplication::primaryScreen()
          ->grabWindow(0, corner.x(), corner.y(), canvas->width(), canvas->height())
          .toImage();
  EXPECT_GT(chart.width(), 100);
  const auto black = pixels(chart, [](QRgb c) { return qGray(c) < 10; }).size();
  EXPECT_LT(static_cast<double>(black), 0.05 * chart.width() * chart.height());
  keep_picture("comparison");
  // The second picture shows a body.
  const QImage picture = second->picture();
  QSet<QRgb> colors;
  for (int x = 0; x < picture.width(); x += 3) {
    for (int y = 0; y < picture.height(); y += 3) colors.insert(picture.pixel(x, y));
  }
  EXPECT_GT(colors.size(), 30);
  // A picture to be saved has both, with their names, and so have those that are recorded.
  const QImage saved = comparison->picture();
  EXPECT_NEAR(saved.width(), first->picture().width() + picture.width(), 4);
  EXPECT_GT(saved.height(), picture.height());
  const int left = saved.width() - picture.width();
  EXPECT_EQ(
      saved.copy(QRect(QPoint(left, 0), picture.size())).convertToFormat(QImage::Format_RGB32),
      picture.convertToFormat(QImage::Format_RGB32));
  EXPECT_EQ(comparison->picture(QSize(1280, 720)).size(), QSize(1280, 720));
  window_->record_pictures(path("pictures"));
  window_->transport()->go_to(0.1);
  wait();
  window_->stop_recording();
  const QImage recorded(path("pictures") + QStringLiteral("/picture_000001.png"));
  EXPECT_EQ(recorded.size(), saved.size());
  EXPECT_NE(recorded.copy(recorded.width() / 2, 0, recorded.width() / 2, recorded.height()),
            saved.copy(recorded.width() / 2, 0, recorded.width() / 2, recorded.height()));
  // Another colour is that of both.
  auto* field = find<QComboBox>("color_field");
  const int speed = field->findText(QStringLiteral("Speed"), Qt::MatchStartsWith);
  ASSERT_GE(speed, 0);
  field->setCurrentIndex(speed);
  emit field->activated(speed);
  EXPECT_EQ(second->state()->field, first->state()->field);
  // It ends with another document.
  open(path("study") + QStringLiteral("/midpoint-0.02"));
  EXPECT_EQ(comparison->second_view(), nullptr);
  EXPECT_TRUE(window_->chart()->other_rows().empty());
  EXPECT_FALSE(find<QLabel>("first_run")->isVisible());
}

TEST_F(Results, ARunIsComparedFromTheMenu) {
  const QString folder = study();
  open(folder + QStringLiteral("/midpoint-0.01"));
  {
    const auto answer = DialogAnswer::path(folder + QStringLiteral("/midpoint-0.02"));
    menu_action(QStringLiteral("Compare &with"))->trigger();
    EXPECT_TRUE(answer.given());
  }
  wait_until_opened();
  ASSERT_NE(window_->comparison()->second_view(), nullptr)
      << window_->messages()->text().toStdString();
  // A motion and an equilibrium have no time in common.
  const QString loading = command({QStringLiteral("static")});
  {
    const auto answer = DialogAnswer::path(loading);
    menu_action(QStringLiteral("Compare &with"))->trigger();
  }
  wait_until_opened();
  expect_told(QStringLiteral("cannot be compared"));
  EXPECT_NE(window_->comparison()->second_view(), nullptr);  // as it was
}

TEST_F(Results, AComputationIsCancelled) {
  show(falling_beam());
  compute("&Study", path("study"), [](QDialog& dialog) {
    fill_study(dialog);
    dialog.findChild<QLineEdit*>(QStringLiteral("study_end"))->setText(QStringLiteral("10000"));
  });
  ASSERT_TRUE(wait_for(
      [&] { return find<QLabel>("computation_text")->text().contains(QStringLiteral("h = ")); }));
  EXPECT_TRUE(find<QPushButton>("computation_cancel")->isVisible());
  click("computation_cancel");
  wait_for_result();
  EXPECT_TRUE(window_->statusBar()->currentMessage().startsWith(QStringLiteral("Cancelled")));
  EXPECT_FALSE(find<QPushButton>("computation_cancel")->isVisible());
  EXPECT_NE(window_->simulation(), nullptr);
  EXPECT_EQ(message(), QString());
  EXPECT_TRUE(menu_action(QStringLiteral("&Study"))->isEnabled());
}

TEST_F(Results, ClosingTheWindowEndsAComputation) {
  show(falling_beam());
  compute("&Study", path("study"), [](QDialog& dialog) {
    fill_study(dialog);
    dialog.findChild<QLineEdit*>(QStringLiteral("study_end"))->setText(QStringLiteral("10000"));
  });
  ASSERT_TRUE(wait_for(
      [&] { return find<QLabel>("computation_text")->text().contains(QStringLiteral("h = ")); }));
  EXPECT_TRUE(window_->close());
  EXPECT_FALSE(computation()->is_running());
}

// The window says what the command said, and goes on.
TEST_F(Results, ACommandThatFailsIsTold) {
  Document free = falling_beam();
  free.scene.fix.clear();
  show(std::move(free));
  compute("&Equilibrium", path("static"));
  wait_for_result();
  expect_told(QStringLiteral("no definite equilibrium"));
  EXPECT_EQ(window_->replay(), nullptr);
  ASSERT_NE(window_->simulation(), nullptr);
  // Values that are none.
  compute("&Study", path("study"), [](QDialog& dialog) {
    fill_study(dialog);
    dialog.findChild<QLineEdit*>(QStringLiteral("study_steps"))->setText(QStringLiteral("-1,abc"));
  });
  wait_for_result();
  expect_told(QStringLiteral("-1"));
  // Folders that cannot take the results.
  QFile file(path("file"));
  ASSERT_TRUE(file.open(QIODevice::WriteOnly));
  file.close();
  compute("Natural &modes", path("file"));
  wait_for_result();
  expect_told(QStringLiteral("file"));
  const QString other = study();
  compute("Natural &modes", other);
  wait_for_result();
  expect_told(QStringLiteral("study"));
  EXPECT_TRUE(QFile::exists(other + QStringLiteral("/study.json")));
  EXPECT_NE(window_->simulation(), nullptr);
}

// Files of results that anybody may have changed.
TEST_F(Results, BrokenResultsAreTold) {
  const auto write = [](const QString& name, const QByteArray& text) {
    QFile file(name);
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(text);
  };
  const QString folder = study();
  const QString json = folder + QStringLiteral("/study.json");
  QFile file(json);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  const QByteArray good = file.readAll();
  file.close();
  for (const QByteArray& text :
       {QByteArray(), QByteArray("{}"), good.left(good.size() / 2),
        QByteArray(good).replace("\"position_error\": 0.0", "\"position_error\": NaN"),
        QByteArray(good).replace("\"directory\": \"midpoint-0.01\"", "\"directory\": \"../..\"")}) {
    write(json, text);
    open(folder);
    expect_told(QStringLiteral("study.json"));
    EXPECT_EQ(window_->replay(), nullptr);
    window_->messages()->clear();
  }
  // The folder of the first run is gone: the next one is shown.
  write(json, good);
  ASSERT_TRUE(QDir(folder + QStringLiteral("/midpoint-0.01")).removeRecursively());
  open(folder);
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_TRUE(QString::fromStdString(window_->replay()->directory()).endsWith("midpoint-0.02"));
  table()->selectRow(0);
  find<QPushButton>("open_run")->click();
  wait_until_opened();
  expect_told(QStringLiteral("midpoint-0.01"));
  EXPECT_EQ(table()->rowCount(), 4);
  // A mode without a file.
  const QString shapes = modes();
  open(shapes);
  ASSERT_EQ(table()->rowCount(), 4) << window_->messages()->text().toStdString();
  ASSERT_TRUE(QFile::remove(shapes + QStringLiteral("/mode_03.vtu")));
  table()->selectRow(2);
  expect_told(QStringLiteral("mode_03.vtu"));
  table()->selectRow(1);
  EXPECT_TRUE(window_->transport()->playing());
  write(shapes + QStringLiteral("/summary.json"), "{\"command\": \"modes\", \"modes\": [NaN]}");
  open(shapes);
  expect_told(QStringLiteral("summary.json"));
}

TEST_F(Results, AStudyWithoutFramesSaysHowToGetThem) {
  const QString folder = command({QStringLiteral("study"), QStringLiteral("--integrators=midpoint"),
                                  QStringLiteral("--steps=1e-2,2e-2"),
                                  QStringLiteral("--frames=none"), QStringLiteral("--no-plots")});
  open(folder);
  EXPECT_EQ(table()->rowCount(), 2);
  expect_told(QStringLiteral("--frames all"));
  table()->selectRow(1);
  find<QPushButton>("open_run")->click();
  wait_until_opened();
  expect_told(QStringLiteral("--frames"));
  EXPECT_EQ(table()->rowCount(), 2);
  EXPECT_EQ(window_->replay(), nullptr);
}

}  // namespace
}  // namespace tetraction::viewer
