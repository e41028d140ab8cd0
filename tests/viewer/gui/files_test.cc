// What is opened and what is written: scenes, meshes, runs.
#include <Eigen/Geometry>
#include <QCheckBox>
#include <QComboBox>
#include <QDropEvent>
#include <QFile>
#include <QLabel>
#include <QMenu>
#include <QMimeData>
#include <QProcess>
#include <QPushButton>
#include <QSlider>
#include <QStatusBar>
#include <QTabBar>
#include <QTemporaryDir>
#include <QUrl>
#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "dialogs.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/probe.h"
#include "viewer/gui/panels/vertex_panel.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Files : public WindowTest {
 protected:
  QString write(const char* name, const char* text) {
    const QString path = folder_.filePath(QLatin1String(name));
    QFile file(path);
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(text);
    return path;
  }
  /// Runs the scene, and records it in a folder with a frame for each five steps.
  std::string record(Session& session, const char* name) {
    const std::string directory = folder_.filePath(QLatin1String(name)).toStdString();
    RunRecorder recorder(directory, 5);
    session.run({&recorder});
    return directory;
  }
  QTemporaryDir folder_;
};

constexpr const char* kScene = R"([mesh]
generate = { kind = "box", size = [1, 0.3, 0.3], cells = [6, 2, 2] }
[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
[time]
step = 0.01
end = 0.3
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
)";

TEST_F(Files, ABrokenSceneIsToldWithItsPlace) {
  open(write("broken.toml", "[mesh]\nfile = \"a.vtu\"\n[materiel]\n"));
  wait();
  expect_told(QStringLiteral("broken.toml:3"));
  EXPECT_EQ(window_->simulation(), nullptr);
  keep_picture("broken_scene");
  // A good one after it.
  open(write("good.toml", kScene));
  wait();
  EXPECT_EQ(message(), QString());
  ASSERT_NE(window_->simulation(), nullptr);
}

TEST_F(Files, TheWindowGoesOnWhileALargeBodyIsRead) {
  show(first_scene());
  window_->simulation()->run();
  QString large = QString::fromLatin1(kScene);
  large.replace(QStringLiteral("[6, 2, 2]"), QStringLiteral("[60, 30, 30]"));
  const QString path = write("large.toml", large.toLatin1().constData());
  const auto before = window_->body_view()->picture_count();
  window_->open(path);
  EXPECT_TRUE(window_->opening());
  EXPECT_TRUE(wait_for(
      [&] { return !window_->opening() || window_->body_view()->picture_count() > before + 3; }));
  EXPECT_TRUE(window_->opening());
  // One at a time.
  window_->open(path);
  expect_told(QStringLiteral("still being read"));
  wait_until_opened();
  EXPECT_EQ(window_->simulation()->mesh().tetrahedron_count(), 324000);
  EXPECT_EQ(message(), QString());
  // Closing meanwhile waits, and nothing is left behind.
  window_->open(path);
  EXPECT_TRUE(window_->close());
  EXPECT_FALSE(window_->opening());
  EXPECT_EQ(window_->simulation(), nullptr);
}

TEST_F(Files, AMeshIsDroppedOnTheWindow) {
  QMimeData data;
  data.setUrls({QUrl::fromLocalFile(QStringLiteral(TETRACTION_DATA "/orbiting_cube.msh"))});
  QDragEnterEvent enter(QPoint(600, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
  QCoreApplication::sendEvent(window_.get(), &enter);
  EXPECT_TRUE(enter.isAccepted());
  QDropEvent drop(QPointF(600, 300), Qt::CopyAction, &data, Qt::LeftButton, Qt::NoModifier);
  QCoreApplication::sendEvent(window_.get(), &drop);
  wait_until_opened();
  ASSERT_NE(window_->simulation(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_GT(window_->simulation()->mesh().tetrahedron_count(), 0);
  press_and_settle(Qt::Key_S);
  EXPECT_EQ(state().step, 1);
}

// A mesh says nothing of what holds it and of its unit: it is free, and its size is told.
TEST_F(Files, AMeshStartsFreeAndCanBeScaled) {
  open(QStringLiteral(TETRACTION_DATA "/orbiting_cube.msh"));
  ASSERT_NE(window_->simulation(), nullptr) << window_->messages()->text().toStdString();
  settle();
  EXPECT_TRUE(
      std::all_of(state().fixed.begin(), state().fixed.end(), [](int f) { return f == 0; }));
  EXPECT_EQ(window_->simulation()->settings().environment.kind, EnvironmentKind::kNone);
  const auto size = [this] {
    Eigen::AlignedBox3d box;
    for (const Vector3& x : window_->simulation()->mesh().vertices) box.extend(x);
    return box.sizes().eval();
  };
  const Vector3 whole = size();
  const auto size_text = [&] {
    return QStringLiteral("%1 × %2 × %3 m").arg(size().x()).arg(size().y()).arg(size().z());
  };
  expect_told(size_text());
  expect_told(QStringLiteral("without gravity"));
  const auto status_tells = [&](const QString& text) {
    const QList<QLabel*> labels = window_->statusBar()->findChildren<QLabel*>();
    return std::any_of(labels.begin(), labels.end(),
                       [&](const QLabel* label) { return label->text().contains(text); });
  };
  EXPECT_TRUE(status_tells(size_text()));
  keep_picture("bare_mesh");
  {  // by the button of the message: millimetres are proposed
    const DialogAnswer answer([](QDialog& dialog) { dialog.accept(); });
    QTest::mouseClick(find<QPushButton>("message_action"), Qt::LeftButton);
    EXPECT_TRUE(answer.given());
    EXPECT_FALSE(answer.stuck());
  }
  wait_until_opened();
  settle();
  EXPECT_LT((size() - 1e-3 * whole).norm(), 1e-12);
  EXPECT_TRUE(status_tells(size_text()));
  expect_told(QStringLiteral("scaled by 0.001"));
  EXPECT_EQ(window_->simulation()->recorded_scene().mesh.scale, 1e-3);
  press_key(Qt::Key_Space);
  EXPECT_TRUE(wait_for([&] { return state().step > 3; }));
  press_key(Qt::Key_Space);
  // Read again, it keeps the scale.
  press_key(Qt::Key_R, Qt::ControlModifier);
  wait_until_opened();
  EXPECT_LT((size() - 1e-3 * whole).norm(), 1e-12);
  // The menu has it, too; not for a scene.
  QAction* scale = menu_action(QStringLiteral("Scale of the mes&h"));
  EXPECT_TRUE(scale->isEnabled());
  for (const char* wrong : {"-1", "0", "many"}) {
    const DialogAnswer answer([wrong](QDialog& dialog) {
      dialog.findChild<QComboBox*>()->setEditText(QLatin1String(wrong));
      dialog.accept();
    });
    scale->trigger();
    EXPECT_TRUE(window_->messages()->text().contains(QStringLiteral("above 0"))) << wrong;
    EXPECT_FALSE(window_->opening());
  }
  open(write("good.toml", kScene));
  EXPECT_FALSE(scale->isEnabled());
  EXPECT_TRUE(status_tells(QStringLiteral("1 × 0.3 × 0.3 m")));
}

TEST_F(Files, ReloadReadsTheFileAgain) {
  const QString path = write("scene.toml", kScene);
  open(path);
  wait();
  press_and_settle(Qt::Key_S);
  QString other = QString::fromLatin1(kScene);
  other.replace(QStringLiteral("1e6"), QStringLiteral("3e6"));
  write("scene.toml", other.toLatin1().constData());
  press_key(Qt::Key_R, Qt::ControlModifier);
  wait_until_opened();
  settle();
  EXPECT_EQ(state().step, 0);
  EXPECT_EQ(*window_->simulation()->settings().materials[0].youngs_modulus, 3e6);
  // One that is gone is told, and what is there stays.
  ASSERT_TRUE(QFile::remove(path));
  press_key(Qt::Key_R, Qt::ControlModifier);
  wait_until_opened();
  expect_told(QStringLiteral("no such file"));
  EXPECT_NE(window_->simulation(), nullptr);
}

TEST_F(Files, ARunIsReplayed) {
  const Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const std::string directory = record(session, "run");

  open(QString::fromStdString(directory));
  wait(300);
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(window_->simulation(), nullptr);
  EXPECT_EQ(window_->replay()->times().size(), 7U);
  EXPECT_EQ(window_->chart()->row_count(), 31U);
  auto* slider = find<QSlider>("timeline");
  slider->setFocus();
  QTest::keyClick(slider, Qt::Key_End);
  wait(200);
  const auto shown = window_->body_view()->state();
  ASSERT_NE(shown, nullptr);
  EXPECT_NEAR(shown->time, 0.3, 1e-12);
  EXPECT_LT((shown->position - session.state().position).norm(), 1e-6);
  EXPECT_EQ(static_cast<Index>(shown->field_values.size()),
            window_->replay()->mesh().tetrahedron_count());
  keep_picture("replay");
  // Nothing can be edited.
  press_key(Qt::Key_A, Qt::ControlModifier);
  auto* panel = window_->findChild<VertexPanel*>();
  ASSERT_NE(panel, nullptr);
  for (const char* name : {"fix", "unfix"}) EXPECT_FALSE(find<QPushButton>(name)->isEnabled());
  panel->fix_wanted();
  panel->unfix_wanted();
  panel->momentum_wanted(Vector3(Vector3::UnitX()));
  EXPECT_NE(window_->replay(), nullptr);
  press_key(Qt::Key_R);
  EXPECT_EQ(slider->value(), 0);
  // A directory without a run says so and leaves the window as it is.
  open(folder_.path());
  expect_told(QStringLiteral("frames.pvd"));
  EXPECT_NE(window_->replay(), nullptr);
}

// Numbers with a decimal comma, as Qt chooses them for a German user, as long as the object lives.
class DecimalComma {
 public:
  explicit DecimalComma(const QString& folder) : before_(std::setlocale(LC_NUMERIC, nullptr)) {
    const QString locale = folder + QStringLiteral("/de_DE.UTF-8");
    QProcess::execute(QStringLiteral("localedef"),
                      {QStringLiteral("-i"), QStringLiteral("de_DE"), QStringLiteral("-f"),
                       QStringLiteral("UTF-8"), locale});
    qputenv("LOCPATH", folder.toLocal8Bit());
    is_set_ = std::setlocale(LC_NUMERIC, "de_DE.UTF-8") != nullptr;
  }
  ~DecimalComma() {
    std::setlocale(LC_NUMERIC, before_.c_str());
    qunsetenv("LOCPATH");
  }
  bool is_set() const { return is_set_; }

 private:
  std::string before_;
  bool is_set_ = false;
};

TEST_F(Files, ARunIsReadTheSameWithADecimalComma) {
  const Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const std::string directory = record(session, "run");
  const DecimalComma comma(folder_.path());
  if (!comma.is_set()) GTEST_SKIP() << "This machine cannot make a German locale.";
  ASSERT_EQ(std::strtod("0,5", nullptr), 0.5);
  const HistoryRow row = Replay(directory).history().back();
  EXPECT_NEAR(row.time, 0.3, 1e-12);
  EXPECT_EQ(row.total, session.balance().energies().total());
}

// History and probes have rows for different steps.
TEST_F(Files, ProbesOfARunAreReplayed) {
  Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  scene.probe = {probe_of("all", ProbeQuantity::kDisplacement, SelectAll{}, 4),
                 probe_of("j", ProbeQuantity::kJacobian, SelectAll{}, 6)};
  scene.output.history_every = 5;
  scene.echo = R"({"probe": [{"name": "all", "quantity": "displacement"},
                             {"name": "j", "quantity": "jacobian"}]})";
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const std::string directory = record(session, "probes");
  ASSERT_EQ(session.step_number(), 30);
  const Replay replay(directory);
  ASSERT_EQ(replay.probes().size(), 2U);
  EXPECT_EQ(replay.probes()[0].columns.size(), 3U);
  EXPECT_EQ(axis_title(replay.probes()[0].axis, replay.probes()[0].unit), "all: displacement [m]");
  std::vector<Index> steps;
  for (const HistoryRow& row : replay.history()) {
    steps.push_back(row.step);
    EXPECT_EQ(std::isnan(row.total), row.step % 5 != 0) << row.step;
    const bool has_all = !row.probes.empty() && !std::isnan(row.probes[0]);
    const bool has_j = !row.probes.empty() && !std::isnan(row.probes[3]);
    EXPECT_EQ(has_all, row.step % 4 == 0 || row.step == 30) << row.step;
    EXPECT_EQ(has_j, row.step % 6 == 0) << row.step;
  }
  EXPECT_EQ(steps, (std::vector<Index>{0, 4, 5, 6, 8, 10, 12, 15, 16, 18, 20, 24, 25, 28, 30}));
  std::vector<double> last(session.probes().value_count());
  session.probes().evaluate(session, last.data());
  EXPECT_EQ(replay.history().back().probes, last);
  open(QString::fromStdString(directory));
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(find<QTabBar>("chart_tabs")->count(), 7);
  // Without the summary, as after a run that was killed, each column is shown alone.
  ASSERT_TRUE(QFile::remove(QString::fromStdString(directory + "/summary.json")));
  EXPECT_EQ(Replay(directory).probes().size(), 4U);
}

TEST_F(Files, FramesWithoutDisplacementsAreNotReplayed) {
  Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  scene.output.fields = {"von_mises"};
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const QString directory = folder_.filePath(QStringLiteral("stress"));
  RunRecorder recorder(directory.toStdString(), 5);
  session.run({&recorder});
  open(directory);
  EXPECT_EQ(window_->replay(), nullptr);
  expect_told(QStringLiteral("output.fields"));
}

TEST_F(Files, ARecordedRunIsReplayed) {
  show(first_scene());
  const QString directory = folder_.filePath(QStringLiteral("recorded"));
  window_->record_run(directory, 10);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().time > 0.3; }));
  open(directory + QStringLiteral("/../scene.toml"));  // not there: the window stays
  window_->simulation()->pause();
  window_->stop_recording();
  settle();
  const Snapshot live = state();
  open(directory);
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  const auto frames = static_cast<std::size_t>(live.step) / 10 + 1;
  EXPECT_EQ(window_->replay()->times().size(), frames + (live.step % 10 != 0));
  EXPECT_EQ(window_->chart()->row_count(), static_cast<std::size_t>(live.step) + 1);
  // All that tetraction run writes: whatever field colours the body is there.
  for (const ColorField field :
       {find_quantity("von_mises"), find_quantity("jacobian"), find_quantity("energy_density")}) {
    const auto frame = Replay(directory.toStdString()).frame(frames - 1, field);
    EXPECT_EQ(static_cast<Index>(frame->field_values.size()),
              window_->replay()->mesh().tetrahedron_count());
  }
  EXPECT_TRUE(QFile::exists(directory + QStringLiteral("/final.vtu")));
  EXPECT_TRUE(QFile::exists(directory + QStringLiteral("/summary.json")));
}

TEST_F(Files, ARecordedSceneReplaysBitwise) {
  open(write("scene.toml", kScene));
  wait();
  ASSERT_NE(window_->simulation(), nullptr);
  for (int i = 0; i < 5; ++i) press_key(Qt::Key_S);
  settle();
  window_->simulation()->edit(SetDamping{{0.0, 2.0, 0.0}}, "Mass damping 2 1/s");
  for (int i = 0; i < 5; ++i) press_key(Qt::Key_S);
  settle();
  const Snapshot live = state();
  const QString path = folder_.filePath(QStringLiteral("recorded.toml"));
  window_->save_scene(path);
  const Scene again = read_scene(path.toStdString());
  Session session(again, generate_mesh(*again.mesh.generate));
  session.run();
  ASSERT_EQ(session.state().step, live.step);
  EXPECT_EQ(0, std::memcmp(session.state().position.data(), live.position.data(),
                           static_cast<std::size_t>(live.position.size()) * sizeof(double)));
}

TEST_F(Files, APictureShowsTheBody) {
  open(write("scene.toml", kScene));
  wait(300);
  const QImage picture = window_->body_view()->picture();
  EXPECT_GT(picture.width(), 300);
  // Something is drawn: more than a background.
  QSet<QRgb> colors;
  for (int x = 0; x < picture.width(); x += 3) {
    for (int y = 0; y < picture.height(); y += 3) colors.insert(picture.pixel(x, y));
  }
  EXPECT_GT(colors.size(), 50);
}

TEST_F(Files, RecentFilesAreOpenedFromTheMenu) {
  const QString first = write("first.toml", kScene);
  const QString second = write("second & last.toml", kScene);
  auto* recent = menu_action(QStringLiteral("Re&cent"))->menu();
  const auto names = [&] {
    QStringList list;
    for (const QAction* action : recent->actions()) {
      // As it is seen: "&&" is "&", one alone underlines a letter.
      QString text = action->text();
      text.replace(QStringLiteral("&&"), QStringLiteral("\n")).remove(QLatin1Char('&'));
      list.push_back(text.replace(QLatin1Char('\n'), QLatin1Char('&')));
    }
    return list;
  };
  EXPECT_FALSE(recent->isEnabled());
  open(first);
  open(second);
  EXPECT_EQ(names(), (QStringList{second, first}));
  open(folder_.filePath(QStringLiteral("missing.toml")));
  EXPECT_EQ(names(), (QStringList{second, first}));
  const auto choose = [&](int entry) {
    recent->popup(window_->mapToGlobal(QPoint(50, 50)));
    ASSERT_TRUE(QTest::qWaitForWindowExposed(recent));
    const QRect place = recent->actionGeometry(recent->actions()[entry]);
    QTest::mouseClick(recent, Qt::LeftButton, Qt::NoModifier, place.center());
    wait_until_opened();
    EXPECT_FALSE(recent->isVisible());
  };
  choose(1);
  EXPECT_EQ(names(), (QStringList{first, second}));
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("first.toml")));
  EXPECT_EQ(message(), QString());
  // They are there in the next window, too; a file that is gone is told.
  window_->close();
  open_window();
  recent = menu_action(QStringLiteral("Re&cent"))->menu();
  EXPECT_EQ(names(), (QStringList{first, second}));
  choose(1);
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("second & last.toml")));
  ASSERT_TRUE(QFile::remove(first));
  choose(1);
  expect_told(QStringLiteral("first.toml"));
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("second & last.toml")));
}

TEST_F(Files, TheNextWindowIsAsThisOneWas) {
  show(quiet_beam());
  raise("dock_drawing");
  click("points");
  click("edges");
  click("clip");
  press_key_in("color_field", Qt::Key_Home);
  press_key_in("color_field", Qt::Key_Down);
  press_key_in("background", Qt::Key_End);
  press_key_in("light_azimuth", Qt::Key_End);
  press_key_in("arrow_scale", Qt::Key_End);
  find<QDockWidget>("dock_charts")->close();
  raise("dock_vertices");
  window_->resize(1100, 700);
  wait();
  window_->close();

  open_window(false);
  wait();
  EXPECT_EQ(window_->size(), QSize(1100, 700));
  EXPECT_FALSE(find<QDockWidget>("dock_charts")->isVisible());
  EXPECT_FALSE(find<QDockWidget>("dock_vertices")->visibleRegion().isEmpty());
  const DrawingSettings& drawing = window_->body_view()->drawing();
  EXPECT_TRUE(drawing.points);
  EXPECT_FALSE(drawing.edges);
  EXPECT_TRUE(drawing.surface);
  EXPECT_FALSE(drawing.clip);  // of one body
  EXPECT_EQ(drawing.field, find_quantity("displacement"));
  EXPECT_EQ(drawing.background, Background::kDark);
  EXPECT_EQ(drawing.light_azimuth, 90.0);
  EXPECT_EQ(drawing.arrow_scale, 4.0);
  EXPECT_TRUE(find<QCheckBox>("points")->isChecked());
  EXPECT_EQ(find<QComboBox>("color_field")->currentIndex(), 1);
  EXPECT_EQ(find<QSlider>("light_azimuth")->value(), 90);
  // The simulation is told of the field that is remembered.
  show(quiet_beam());
  settle();
  EXPECT_EQ(state().field, find_quantity("displacement"));
}

TEST_F(Files, ClosingWhileRunningStops) {
  show(first_scene());
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return state().running && state().step > 1; }));
  EXPECT_TRUE(window_->close());
  EXPECT_EQ(window_->simulation(), nullptr);
}

// Load steps have a load factor instead of a time, and nothing of a motion.
TEST_F(Files, AnEquilibriumIsReplayedOverTheLoadFactor) {
  const Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  Session session(scene, generate_mesh(*scene.mesh.generate), Analysis::kEquilibrium, 0.25);
  const std::string directory = folder_.filePath(QStringLiteral("static")).toStdString();
  RunRecorder recorder(directory, 1);
  session.run({&recorder});
  show(quiet_beam());
  ASSERT_EQ(find<QTabBar>("chart_tabs")->count(), 6);
  open(QString::fromStdString(directory));
  ASSERT_NE(window_->replay(), nullptr) << window_->messages()->text().toStdString();
  EXPECT_EQ(window_->replay()->kind(), RunKind::kEquilibrium);
  auto* tabs = find<QTabBar>("chart_tabs");
  ASSERT_EQ(tabs->count(), 2);
  EXPECT_EQ(tabs->tabText(0), QStringLiteral("Energy"));
  EXPECT_EQ(find<QCheckBox>("series_0")->text(), QStringLiteral("Elastic"));
  EXPECT_EQ(window_->chart()->horizontal_title(), "Load factor");
  const HistoryRow& last = window_->chart()->rows().back();
  EXPECT_EQ(last.time, 1.0);
  EXPECT_GT(last.elastic, 0.0);
  EXPECT_TRUE(std::isnan(last.kinetic) && std::isnan(last.energy_error));
  EXPECT_FALSE(history_text(window_->chart()->rows()).empty());
  const auto labels = [this] {
    QStringList texts;
    for (const QLabel* label : window_->findChildren<QLabel*>()) {
      if (label->isVisible()) texts += label->text();
    }
    return texts.join(QLatin1Char('\n'));
  };
  EXPECT_TRUE(labels().contains(QStringLiteral("load factor,\nframe 1 of")));
  EXPECT_EQ(find<QLabel>("time")->text(), QStringLiteral("0.0000")) << "it is no time";
  keep_picture("replay_static");
  // A motion has its charts again.
  show(quiet_beam());
  EXPECT_EQ(tabs->count(), 6);
  EXPECT_EQ(window_->chart()->horizontal_title(), "Time [s]");
}

// A replay has no settings that could be changed. Those of the scene before are not its own.
TEST_F(Files, AReplayShowsNoSettingsOfTheSceneBefore) {
  const Scene scene = read_scene(write("scene.toml", kScene).toStdString());
  Session session(scene, generate_mesh(*scene.mesh.generate));
  const QString directory = folder_.filePath(QStringLiteral("run"));
  RunRecorder recorder(directory.toStdString(), 10);
  session.run({&recorder});
  show(quiet_beam());
  show_entry("material");
  const auto panels = {std::pair("dock_scene", "scene_tree"),
                       std::pair("dock_inspector", "youngs_modulus")};
  for (const auto& [dock, field] : panels) {
    raise(dock);
    EXPECT_TRUE(find<QWidget>(field)->isVisible());
  }
  open(directory);
  ASSERT_NE(window_->replay(), nullptr);
  window_->resize(1024, 700);
  for (const auto& [dock, field] : panels) {
    raise(dock);
    EXPECT_FALSE(find<QWidget>(field)->isVisible()) << dock;
    auto* text = find<QDockWidget>(dock)->findChild<QLabel*>(QStringLiteral("replay_text"));
    ASSERT_NE(text, nullptr) << dock;
    EXPECT_TRUE(text->isVisible()) << dock;
    wait();
    EXPECT_EQ(text->visibleRegion().boundingRect().width(), text->width()) << dock << ": it is cut";
    EXPECT_GE(text->height(), text->heightForWidth(text->width())) << dock;
  }
  keep_picture("replay_settings");
  show(quiet_beam());
  EXPECT_TRUE(find<QWidget>("steps_per_picture")->isVisible());
}

}  // namespace
}  // namespace tetraction::viewer
