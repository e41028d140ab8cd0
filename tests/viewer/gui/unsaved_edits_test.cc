// Edits that are not saved outlive a crash of the program.
#include <QFile>
#include <QProcess>
#include <QTemporaryDir>
#include <csignal>

#include "tetraction/io/scene_writer.h"
#include "window_test.h"

namespace tetraction::viewer {
namespace {

constexpr const char* kChild = "Unsaved.DISABLED_AProgramThatIsKilled";

class Unsaved : public WindowTest {
 protected:
  static QString path() { return qEnvironmentVariable("TETRACTION_TEST_SCENE"); }
  // Another program opens the scene, makes edits and is killed.
  void crash() {
    scene_path_ = folder_.filePath(QStringLiteral("beam.toml"));
    Document beam = quiet_beam();
    beam.scene.time.end = 1.0;
    write_scene(beam.scene, scene_path_.toStdString());
    QProcess program;
    QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
    environment.insert(QStringLiteral("TETRACTION_TEST_SCENE"), scene_path_);
    environment.insert(QStringLiteral("TETRACTION_TEST_SETTINGS"), settings_folder());
    program.setProcessEnvironment(environment);
    program.setProcessChannelMode(QProcess::ForwardedChannels);
    program.start(QCoreApplication::applicationFilePath(),
                  {QStringLiteral("--gtest_filter=%1").arg(QLatin1String(kChild)),
                   QStringLiteral("--gtest_also_run_disabled_tests")});
    ASSERT_TRUE(program.waitForFinished(120000));
    EXPECT_EQ(program.exitStatus(), QProcess::CrashExit);
  }
  static QString settings_folder() {
    return QFileInfo(QFileInfo(QSettings().fileName()).path()).path();
  }
  QStringList kept_files() const {
    return QDir(QFileInfo(QSettings().fileName()).dir().filePath(QStringLiteral("unsaved")))
        .entryList({QStringLiteral("*.toml")}, QDir::Files);
  }
  void TearDown() override {
    window_.reset();
    EXPECT_TRUE(kept_files().isEmpty());
  }

  QTemporaryDir folder_;
  QString scene_path_;
};

TEST_F(Unsaved, DISABLED_AProgramThatIsKilled) {
  if (path().isEmpty()) GTEST_SKIP() << "Another test starts it.";
  open(path());
  make_edit(SetDamping{{.drag = 0.25}}, "Drag");
  window_->simulation()->step();
  settle();
  make_edit(SetDamping{{.drag = 0.5}}, "Drag");
  window_->keep_unsaved_edits();
  std::raise(SIGKILL);
}

TEST_F(Unsaved, EditsAreOfferedAfterACrashAndRestored) {
  crash();
  show(quiet_beam());
  window_->offer_unsaved_edits();
  wait();
  expect_told(QStringLiteral("beam.toml"));
  {
    // Another window does not offer them as long as this one does.
    MainWindow other;
    other.show_document(quiet_beam());
    other.offer_unsaved_edits();
    EXPECT_FALSE(other.messages()->text().contains(QStringLiteral("beam.toml")));
  }
  QTest::mouseClick(action_button(QStringLiteral("Restore")), Qt::LeftButton);
  wait_until_opened();
  settle();
  EXPECT_TRUE(window_->windowTitle().startsWith(QStringLiteral("beam.toml")));
  EXPECT_EQ(window_->simulation()->settings().damping.drag, 0.25) << "the edit at the start";
  press_and_settle(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(window_->simulation()->settings().damping.drag, quiet_beam().scene.damping.drag);
  EXPECT_TRUE(window_->simulation()->scene().event.empty()) << "one undo takes all edits back";
  EXPECT_EQ(window_->simulation()->undo_text(), "");
  press_and_settle(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_EQ(window_->simulation()->settings().damping.drag, 0.25);
  window_->simulation()->step();
  window_->simulation()->step();
  settle();
  EXPECT_EQ(window_->simulation()->settings().damping.drag, 0.5);
  EXPECT_EQ(kept_files().size(), 1) << "they are still not saved";
  EXPECT_TRUE(window_->save_scene(folder_.filePath(QStringLiteral("saved.toml"))));
  EXPECT_TRUE(kept_files().isEmpty());
}

TEST_F(Unsaved, EditsAreDiscarded) {
  crash();
  show(quiet_beam());
  window_->offer_unsaved_edits();
  wait();
  QTest::mouseClick(action_button(QStringLiteral("Discard")), Qt::LeftButton);
  EXPECT_TRUE(kept_files().isEmpty());
  EXPECT_EQ(message(), QString());
}

TEST_F(Unsaved, AMeshOfAFileIsFoundFromTheOtherFolder) {
  show(quiet_beam());
  window_->keep_unsaved_edits();
  EXPECT_TRUE(kept_files().isEmpty()) << "there are no edits";
  open(QStringLiteral(TETRACTION_DATA "/orbiting_cube.msh"));
  make_edit(SetDamping{{.drag = 0.25}}, "Drag");
  window_->keep_unsaved_edits();
  ASSERT_EQ(kept_files().size(), 1);
  const Document kept = open_scene(QFileInfo(QSettings().fileName())
                                       .dir()
                                       .filePath(QStringLiteral("unsaved/") + kept_files().front())
                                       .toStdString());
  EXPECT_EQ(kept.mesh.vertex_count(), window_->simulation()->mesh().vertex_count());
  window_->close_without_question();
  EXPECT_TRUE(kept_files().isEmpty());
}

}  // namespace
}  // namespace tetraction::viewer
