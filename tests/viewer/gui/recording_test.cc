// What is recorded while the body moves: pictures, frames; and what cannot be written.
#include <QDirIterator>
#include <QElapsedTimer>
#include <QFile>
#include <QJsonDocument>
#include <QJsonObject>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QStatusBar>
#include <QTemporaryDir>
#include <QThreadPool>

#include "dialogs.h"
#include "pictures.h"
#include "support/gated_material.h"
#include "tetraction/io/scene_reader.h"
#include "viewer/gui/transport/transport_bar.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

class Recordings : public WindowTest {
 protected:
  QString path(const char* name) const { return folder_.filePath(QLatin1String(name)); }
  static QStringList files(const QString& folder, const char* pattern) {
    return QDir(folder).entryList({QLatin1String(pattern)}, QDir::Files, QDir::Name);
  }
  // Nobody can write below a file, not even root.
  QString below_a_file() {
    QFile file(path("file"));
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    return path("file/below");
  }
  void make_step() { press_and_settle(Qt::Key_S); }
  std::string message() { return window_->messages()->text().toStdString(); }
  // The replay of what was recorded, with a frame for each file.
  void expect_replay(const QString& directory) {
    const int frames = files(directory + QStringLiteral("/frames"), "frame_*.vtu").size();
    open(directory);
    ASSERT_NE(window_->replay(), nullptr) << message();
    const Replay& replay = *window_->replay();
    ASSERT_EQ(static_cast<int>(replay.times().size()), frames);
    for (std::size_t i = 0; i < replay.times().size(); ++i) {
      if (i > 0) {
        EXPECT_GT(replay.times()[i], replay.times()[i - 1]);
      }
      EXPECT_EQ(replay.frame(i, find_quantity("velocity"))->position.size(),
                3 * replay.mesh().vertex_count());
    }
    ASSERT_FALSE(replay.history().empty());
    EXPECT_GE(replay.history().back().time, replay.times().back());
    window_->transport()->timeline()->setValue(window_->transport()->timeline()->maximum());
    EXPECT_EQ(static_cast<int>(window_->transport()->frame()), frames - 1);
  }

  QTemporaryDir folder_;
};

TEST_F(Recordings, PicturesAreNumberedAndShowTheMotion) {
  show(first_scene());
  window_->record_pictures(folder_.path());
  EXPECT_TRUE(menu_action(QStringLiteral("Record &pictures"))->isChecked());
  window_->simulation()->run();
  ASSERT_TRUE(
      wait_for([&] { return state().time > 0.3 && files(folder_.path(), "*").size() > 3; }));
  const QSize size = window_->body_view()->picture().size();
  window_->stop_recording();
  EXPECT_FALSE(menu_action(QStringLiteral("Record &pictures"))->isChecked());
  const QString told = window_->statusBar()->currentMessage();
  QThreadPool::globalInstance()->waitForDone();
  const QStringList names = files(folder_.path(), "*");
  ASSERT_GT(names.size(), 3);
  EXPECT_TRUE(told.startsWith(QString::number(names.size()))) << told.toStdString();
  for (int i = 0; i < names.size(); ++i) {
    EXPECT_EQ(names[i], QStringLiteral("picture_%1.png").arg(i + 1, 6, 10, QLatin1Char('0')));
  }
  const QImage first(folder_.filePath(names.front()));
  const QImage last(folder_.filePath(names.back()));
  EXPECT_EQ(first.size(), size);
  EXPECT_GT(differing_pixels(first, last), 1000);
  // No more come.
  settle_running();
  QThreadPool::globalInstance()->waitForDone();
  EXPECT_EQ(files(folder_.path(), "*").size(), names.size());
}

TEST_F(Recordings, ARunHasAFrameForEachTime) {
  show(first_scene());
  const QString directory = path("run");
  window_->record_run(directory, 7);
  EXPECT_TRUE(menu_action(QStringLiteral("Record &run"))->isChecked());
  // Edits while paused are of the same time, and make no second frame of it.
  press_key_in("color_field", Qt::Key_Home);
  settle();
  press_key_in("color_field", Qt::Key_End);
  settle();
  run_to(0.3);
  settle();
  const Snapshot live = state();
  window_->stop_recording();
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());
  settle();  // the solver's thread writes
  expect_replay(directory);
  // It is complete, as a run of the saved scene is.
  QFile summary(directory + QStringLiteral("/summary.json"));
  ASSERT_TRUE(summary.open(QIODevice::ReadOnly));
  const QJsonObject json = QJsonDocument::fromJson(summary.readAll()).object();
  EXPECT_EQ(json[QLatin1String("status")].toString(), QStringLiteral("ok"));
  EXPECT_EQ(json[QLatin1String("exit_status")].toInt(-1), 0);
  EXPECT_EQ(json[QLatin1String("steps_planned")], json[QLatin1String("steps")]);
  const Replay& replay = *window_->replay();
  EXPECT_GE(replay.times().size(), 3U);
  EXPECT_EQ(replay.times().front(), 0.0);
  const std::size_t end = replay.times().size() - 1;
  EXPECT_EQ(replay.times().back(), live.time);
  EXPECT_LT((replay.frame(end, find_quantity("velocity"))->position - live.position).norm(), 1e-6);
}

TEST_F(Recordings, AResetEndsTheRecordingOfARun) {
  show(first_scene());
  const QString directory = path("run");
  window_->record_run(directory, 10);
  run_to(0.3);
  press_and_settle(Qt::Key_R);
  run_to(0.1);
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());
  window_->stop_recording();
  settle();
  expect_replay(directory);
  EXPECT_GT(window_->replay()->times().back(), 0.3);
}

TEST_F(Recordings, WhatWasRecordedBeforeIsNotOverwritten) {
  show(quiet_beam());
  const QString directory = path("run");
  window_->record_run(directory, 10);
  settle();
  window_->stop_recording();
  window_->record_run(directory, 10);
  EXPECT_NE(message().find("Choose an empty folder"), std::string::npos) << message();
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());

  window_->record_pictures(folder_.path());
  press_and_settle(Qt::Key_S);
  window_->stop_recording();
  QThreadPool::globalInstance()->waitForDone();
  ASSERT_TRUE(QFile::exists(path("picture_000001.png")));
  window_->messages()->clear();
  window_->record_pictures(folder_.path());
  EXPECT_NE(message().find("Choose an empty folder"), std::string::npos) << message();
  EXPECT_FALSE(menu_action(QStringLiteral("Record &pictures"))->isChecked());
}

TEST_F(Recordings, AFolderThatCannotBeWrittenIsTold) {
  show(quiet_beam());
  const QString nowhere = below_a_file();
  const auto told = [&] {
    const bool so = message().find(nowhere.toStdString()) != std::string::npos;
    EXPECT_TRUE(so) << message();
    window_->messages()->clear();
    return so;
  };
  window_->record_run(nowhere, 1);
  EXPECT_TRUE(wait_for([&] { return window_->messages()->text().contains(nowhere); }));
  EXPECT_TRUE(told());
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());
  window_->record_pictures(nowhere);
  EXPECT_TRUE(told());
  EXPECT_FALSE(menu_action(QStringLiteral("Record &pictures"))->isChecked());
  window_->save_scene(nowhere + QStringLiteral(".toml"));
  EXPECT_TRUE(told());
  for (const char* ending : {".csv", ".png", ".svg"}) {
    window_->statusBar()->clearMessage();
    window_->chart()->save_as(nowhere + QLatin1String(ending));
    EXPECT_TRUE(window_->statusBar()->currentMessage().contains(nowhere)) << ending;
    EXPECT_FALSE(window_->statusBar()->currentMessage().contains(QStringLiteral("is written")))
        << ending;
  }
}

// The disk is full, the folder is gone: told as soon as it is known, and the recording ends.
TEST_F(Recordings, APlaceThatIsLostMeanwhileIsTold) {
  show(first_scene());
  const QString pictures = path("pictures");
  const QString run = path("run");
  ASSERT_TRUE(QDir().mkpath(pictures));
  window_->record_pictures(pictures);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] { return files(pictures, "*.png").size() > 1; }));
  ASSERT_TRUE(wait_for([&] { return QDir(pictures).removeRecursively(); }));
  EXPECT_TRUE(wait_for([&] { return window_->messages()->text().contains(pictures); }));
  EXPECT_FALSE(menu_action(QStringLiteral("Record &pictures"))->isChecked());

  window_->messages()->clear();
  window_->record_run(run, 1);
  ASSERT_TRUE(wait_for([&] { return files(run, "frames.pvd").size() == 1; }));
  ASSERT_TRUE(wait_for([&] { return QDir(run).removeRecursively(); }));
  QFile in_its_place(run);
  ASSERT_TRUE(in_its_place.open(QIODevice::WriteOnly));
  EXPECT_TRUE(wait_for([&] { return window_->messages()->text().contains(run); }));
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());
}

TEST_F(Recordings, ClosingCompletesWhatIsRecorded) {
  show(first_scene());
  const QString directory = path("run");
  window_->record_run(directory, 5);
  window_->record_pictures(folder_.path());
  window_->simulation()->set_speed_limit(0.0);
  window_->simulation()->run();
  ASSERT_TRUE(wait_for([&] {
    return state().time > 0.3 && files(directory + QStringLiteral("/frames"), "*").size() > 3;
  }));
  QElapsedTimer time;
  time.start();
  EXPECT_TRUE(window_->close());
  EXPECT_LT(time.elapsed(), 3000);
  EXPECT_EQ(window_->simulation(), nullptr);
  window_.reset();
  QThreadPool::globalInstance()->waitForDone();
  for (const QString& name : files(folder_.path(), "*.png")) {
    EXPECT_FALSE(QImage(folder_.filePath(name)).isNull()) << name.toStdString();
  }
  open_window();
  expect_replay(directory);
  EXPECT_GE(window_->replay()->times().size(), 3U);
}

TEST_F(Recordings, MenusAskForFilesAndFolders) {
  show(first_scene());
  const auto choose = [this](const char* action, const QString& path) {
    const DialogAnswer answer = DialogAnswer::path(path);
    menu_action(QLatin1String(action))->trigger();
    EXPECT_TRUE(answer.given()) << action;
    EXPECT_FALSE(answer.stuck()) << action;
    wait_until_opened();
  };
  choose("Save s&creenshot", path("shot.png"));
  EXPECT_EQ(QImage(path("shot.png")).size(), window_->body_view()->picture().size());
  EXPECT_EQ(differing_pixels(QImage(path("shot.png")), window_->body_view()->picture()), 0);
  choose("&Save recorded scene", path("scene.toml"));
  EXPECT_TRUE(QFile::exists(path("scene.toml")));

  // A folder that is there, and one that is made.
  ASSERT_TRUE(QDir().mkpath(path("run")));
  choose("Record &run", path("run"));
  EXPECT_TRUE(menu_action(QStringLiteral("Record &run"))->isChecked());
  choose("Record &pictures", path("pictures"));
  EXPECT_TRUE(menu_action(QStringLiteral("Record &pictures"))->isChecked());
  run_to(0.1);
  menu_action(QStringLiteral("Record &pictures"))->trigger();
  menu_action(QStringLiteral("Record &run"))->trigger();
  QThreadPool::globalInstance()->waitForDone();
  EXPECT_FALSE(files(path("pictures"), "picture_*.png").isEmpty());
  settle();
  EXPECT_TRUE(QFile::exists(path("run/summary.json")));

  // A dialog that is left without a choice changes nothing.
  {
    const DialogAnswer none([](QDialog& dialog) { QTest::keyClick(&dialog, Qt::Key_Escape); });
    menu_action(QStringLiteral("Record &pictures"))->trigger();
    EXPECT_TRUE(none.given());
  }
  EXPECT_FALSE(menu_action(QStringLiteral("Record &pictures"))->isChecked());

  choose("&Open scene", path("scene.toml"));
  ASSERT_NE(window_->simulation(), nullptr);
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("scene.toml")));
  choose("Open &run", path("run"));
  EXPECT_NE(window_->replay(), nullptr) << message();
  choose("Open &mesh", QStringLiteral(TETRACTION_DATA "/orbiting_cube.msh"));
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("orbiting_cube.msh"))) << message();
}

// The dialog's button of this kind is pressed. `given`: whether it was there.
class SaveAnswer : public DialogAnswer {
 public:
  explicit SaveAnswer(QMessageBox::StandardButton button, const QString& path = {})
      : DialogAnswer([button, path](QDialog& dialog) {
          if (auto* box = qobject_cast<QMessageBox*>(&dialog)) {
            ASSERT_NE(box->button(button), nullptr);
            box->button(button)->click();
          } else if (auto* name = dialog.findChild<QLineEdit*>(QStringLiteral("fileNameEdit"))) {
            name->setCompleter(nullptr);
            name->setText(path);
            QTest::keyClick(name, Qt::Key_Return);
          }
        }) {}
};

// Calls a function when a widget is hidden.
class HideWatch : public QObject {
 public:
  HideWatch(QWidget& widget, std::function<void()> call) : call_(std::move(call)) {
    widget.installEventFilter(this);
  }
  bool eventFilter(QObject*, QEvent* event) override {
    if (event->type() == QEvent::Hide) call_();
    return false;
  }

 private:
  std::function<void()> call_;
};

TEST_F(Recordings, EditsThatAreNotSavedAreNotLostUnasked) {
  const auto drag_now = [this] { return window_->simulation()->settings().damping.drag; };
  const auto edit = [this](double drag) { make_edit(SetDamping{{.drag = drag}}, "Drag"); };
  show(quiet_beam());
  window_->save_scene(path("other.toml"));
  edit(0.25);
  {
    const SaveAnswer answer(QMessageBox::Cancel);
    EXPECT_FALSE(window_->close());
    EXPECT_TRUE(answer.given());
  }
  ASSERT_NE(window_->simulation(), nullptr);
  EXPECT_TRUE(window_->isVisible());
  {
    const SaveAnswer answer(QMessageBox::Cancel);
    open(path("other.toml"));
    EXPECT_TRUE(answer.given());
  }
  EXPECT_EQ(drag_now(), 0.25);
  EXPECT_FALSE(window_->save_scene(below_a_file()));
  {
    const SaveAnswer answer(QMessageBox::Save, path("saved.toml"));
    open(path("other.toml"));
    EXPECT_TRUE(answer.given());
    EXPECT_FALSE(answer.stuck());
  }
  EXPECT_TRUE(QFile::exists(path("saved.toml")));
  EXPECT_EQ(drag_now(), 0.0);
  edit(0.5);
  {
    const SaveAnswer answer(QMessageBox::Discard);
    open(path("saved.toml"));
    EXPECT_TRUE(answer.given());
  }
  make_step();
  EXPECT_EQ(drag_now(), 0.25);
  // Nothing to save: nothing is asked.
  const SaveAnswer none(QMessageBox::Cancel);
  edit(0.75);
  EXPECT_TRUE(window_->save_scene(path("again.toml")));
  open(path("other.toml"));
  EXPECT_EQ(drag_now(), 0.0);
  edit(0.5);
  window_->simulation()->undo();
  settle();
  EXPECT_TRUE(window_->close());
  EXPECT_FALSE(none.given());
}

// The solver does not answer, as in the factorisation of a large matrix.
TEST_F(Recordings, TheWindowClosesAtOnceInAStepThatLasts) {
  const auto gate = std::make_shared<testing_support::Gate>();
  Document document = quiet_beam();
  document.scene.material.custom =
      MaterialModel(CustomMaterial(testing_support::GatedRubber(lame_from_young(1e5, 0.3), gate)));
  document.scene.time = {Integrator::kMidpoint, 1e-3, false, 1000.0};
  show(std::move(document));
  window_->record_run(path("run"), 1);
  make_step();
  make_step();
  gate->close();
  window_->simulation()->step();
  ASSERT_TRUE(gate->wait_for_thread());
  bool hidden_first = false;
  const HideWatch watch(*window_, [&] { hidden_first = !QFile::exists(path("run/summary.json")); });
  EXPECT_TRUE(window_->close());
  EXPECT_TRUE(hidden_first) << "the window goes away before anything is waited for";
  EXPECT_FALSE(window_->isVisible());
  EXPECT_TRUE(window_->closed_within_step());
  for (const char* name : {"run/summary.json", "run/final.vtu", "run/frames/frame_000002.vtu"}) {
    EXPECT_TRUE(QFile::exists(path(name))) << name;
  }
  gate->open();
  window_.reset();
}

// A restart ends the recording of the run and takes the times of the edits away.
TEST_F(Recordings, ARestartTellsWhatItLoses) {
  show(quiet_beam());
  make_step();
  press_and_settle(Qt::Key_R);
  EXPECT_EQ(WindowTest::message(), QString()) << "nothing is lost";
  make_step();
  make_edit(SetDamping{{.drag = 0.25}}, "Drag");
  window_->record_run(path("run"), 1);
  make_step();
  press_and_settle(Qt::Key_R);
  EXPECT_NE(message().find("times of the edits"), std::string::npos) << message();
  EXPECT_NE(message().find(path("run").toStdString()), std::string::npos) << message();
  EXPECT_FALSE(menu_action(QStringLiteral("Record &run"))->isChecked());
  keep_picture("restart_message");
  const DialogAnswer answer = DialogAnswer::path(path("before.toml"));
  QTest::mouseClick(find<QPushButton>("message_action"), Qt::LeftButton);
  EXPECT_TRUE(answer.given());
  const Scene before = read_scene(path("before.toml").toStdString());
  ASSERT_EQ(before.event.size(), 1U);
  EXPECT_GT(before.event[0].at, 0.0) << "the time of the edit";
}

}  // namespace
}  // namespace tetraction::viewer
