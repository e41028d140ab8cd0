// Saves scenes, and records pictures and runs.
#include <QAction>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QInputDialog>
#include <QStatusBar>
#include <QThreadPool>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "main_window.h"
#include "tetraction/core/error.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_writer.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/panels/control_panel.h"

namespace tetraction::viewer {
namespace {

constexpr int kMostWaiting = 16;  // largest number of pictures in the queue

QString picture_path(const QString& folder, std::size_t number) {
  return QDir(folder).filePath(
      QStringLiteral("picture_%1.png").arg(number, 6, 10, QLatin1Char('0')));
}

QString ask_scene_path(QWidget* parent) {
  return QFileDialog::getSaveFileName(
      parent, MainWindow::tr("Save the scene with all edits as events"),
      QStringLiteral("recorded.toml"), MainWindow::tr("Scenes (*.toml)"));
}

}  // namespace

/// Pictures that are being written to the disk.
struct PictureQueue {
  std::atomic<int> waiting = 0;
  std::atomic<bool> failed = false;
};

// These functions return whether the scene is saved.
bool MainWindow::ask_save_scene() {
  const QString path = ask_scene_path(this);
  return !path.isEmpty() && save_scene(path);
}

bool MainWindow::ask_save_scene(const Scene& scene) {
  const QString path = ask_scene_path(this);
  return !path.isEmpty() && write(scene, path);
}

bool MainWindow::save_scene(const QString& path) {
  const std::size_t edits = simulation_->edit_count();
  if (!write(simulation_->recorded_scene(), path)) return false;
  saved_edits_ = edits;
  return true;
}

bool MainWindow::write(const Scene& scene, const QString& path) {
  try {
    write_scene(scene, path.toLocal8Bit().toStdString());
    statusBar()->showMessage(tr("%1 is written: replay it with tetraction run.").arg(path), 8000);
    return true;
  } catch (const Error& error) {
    show_error(QString::fromUtf8(error.what()));
    return false;
  }
}

void MainWindow::ask_save_screenshot() {
  const QString path = QFileDialog::getSaveFileName(
      this, tr("Save what the view shows"), QStringLiteral("body.png"), tr("Pictures (*.png)"));
  if (path.isEmpty()) return;
  if (view_->picture().save(path)) {
    statusBar()->showMessage(tr("%1 is written.").arg(path), 8000);
  } else {
    show_error(tr("%1: cannot be written. Choose another folder.").arg(path));
  }
}

void MainWindow::ask_record_pictures(bool on) {
  const QString folder =
      on ? QFileDialog::getExistingDirectory(this, tr("Folder for picture_000001.png and so on"))
         : QString();
  if (folder.isEmpty()) {
    stop_pictures();
  } else {
    record_pictures(folder);
  }
}

void MainWindow::stop_pictures() {
  if (picture_folder_.isEmpty()) {
    show_recording();
    return;
  }
  QThreadPool::globalInstance()->waitForDone();
  const QString folder = std::exchange(picture_folder_, QString());
  if (simulation_) simulation_->set_picture_interval(0.0);
  show_recording();
  if (picture_queue_->failed) {
    show_error(tr("%1: not all pictures could be written. Choose another folder.").arg(folder));
  } else {
    statusBar()->showMessage(tr("%1 pictures are in %2.").arg(pictures_recorded_).arg(folder),
                             8000);
  }
}

// Ends the recording of pictures if one could not be written.
void MainWindow::check_pictures() {
  if (!picture_folder_.isEmpty() && picture_queue_->failed) stop_pictures();
}

void MainWindow::show_error(const QString& message) {
  messages_->show_message(MessageStrip::Kind::kError, message);
}

// Shows in the menu what is being recorded.
void MainWindow::show_recording() {
  const QSignalBlocker quiet_pictures(record_pictures_);
  const QSignalBlocker quiet_run(record_run_);
  record_pictures_->setChecked(!picture_folder_.isEmpty());
  record_run_->setChecked(!run_folder_.isEmpty());
  QStringList what;
  if (!run_folder_.isEmpty()) what += tr("run");
  if (!picture_folder_.isEmpty()) what += tr("pictures");
  status_recording_->setText(tr("● recording: %1").arg(what.join(QLatin1String(", "))));
  status_recording_->setToolTip(
      QStringList{run_folder_, picture_folder_}.join(QLatin1Char('\n')).trimmed());
  status_recording_->setVisible(!what.isEmpty());
  view_->set_recording(!picture_folder_.isEmpty());
}

void MainWindow::record_pictures(const QString& folder) {
  stop_pictures();
  if (QFileInfo::exists(picture_path(folder, 1))) {
    show_error(tr("%1: there are pictures in it already, which would be lost. Choose an empty "
                  "folder.")
                   .arg(folder));
  } else if (!QDir().mkpath(folder)) {
    show_error(tr("%1: cannot be made. Choose another folder.").arg(folder));
  } else {
    picture_folder_ = folder;
    pictures_recorded_ = 0;
    picture_queue_ = std::make_shared<PictureQueue>();
    next_picture_ = -1.0;
    if (simulation_) {
      // Twenty-five pictures for a second of the film, at the speed that is set.
      constexpr double kRate = 25.0;
      const double speed = control_->speed_limit() > 0.0 ? control_->speed_limit() : 1.0;
      picture_interval_ = std::max(speed / kRate, simulation_->settings().time.step);
      simulation_->set_picture_interval(picture_interval_);
    }
  }
  show_recording();
}

// Pictures of a simulation are equally spaced in simulated time. Of a replay there is one for each frame.
void MainWindow::record_picture() {
  if (simulation_) {
    constexpr double kRoundOff = 1e-9;
    const double number = std::floor(view_->state()->time / picture_interval_ + kRoundOff);
    if (number == next_picture_) return;
    next_picture_ = number;
  }
  auto save = [image = view_->picture(), queue = picture_queue_,
               path = picture_path(picture_folder_, ++pictures_recorded_)] {
    if (!image.save(path)) queue->failed = true;
    --queue->waiting;
  };
  // Compressing takes longer than drawing. It runs in other threads unless too many pictures wait.
  if (++picture_queue_->waiting > kMostWaiting) {
    save();
  } else {
    QThreadPool::globalInstance()->start(std::move(save));
  }
}

void MainWindow::ask_record_run(bool on) {
  QString folder;
  bool wanted = false;
  int frame_every = 1;
  if (on) {
    folder = QFileDialog::getExistingDirectory(
        this, tr("Empty folder for frames.pvd, history.csv, summary.json"));
    constexpr double kFramesASecond = 25.0;
    const double steps = 1.0 / (kFramesASecond * simulation_->settings().time.step);
    const int usual = static_cast<int>(std::clamp(std::round(steps), 1.0, 1e6));
    if (!folder.isEmpty()) {
      frame_every = QInputDialog::getInt(this, tr("Record the run"),
                                         tr("Steps from frame to frame (proposed: %1 frames a "
                                            "simulated second)")
                                             .arg(kFramesASecond),
                                         usual, 1, 100'000'000, 1, &wanted);
    }
  }
  if (wanted) {
    record_run(folder, frame_every);
  } else {
    if (simulation_ && !run_folder_.isEmpty()) simulation_->observe(nullptr);
    show_recording();
  }
}

// Called when the solver's thread has ended the recording: on command, because the run failed or was
// reset, or because of an error, for which there is a notice.
void MainWindow::report_end_of_run_recording() {
  statusBar()->showMessage(tr("The recording in %1 has ended.").arg(run_folder_), 8000);
  run_folder_.clear();
  show_recording();
}

void MainWindow::stop_recording() {
  stop_pictures();
  if (simulation_ && !run_folder_.isEmpty()) simulation_->observe(nullptr);
  run_folder_.clear();
  show_recording();
}

void MainWindow::record_run(const QString& folder, int frame_every) {
  if (QFileInfo::exists(QDir(folder).filePath(QStringLiteral("frames.pvd")))) {
    show_error(tr("%1: there is a run in it already, which would be lost. Choose an empty folder.")
                   .arg(folder));
  } else {
    run_folder_ = folder;
    simulation_->observe(
        std::make_unique<RunRecorder>(folder.toLocal8Bit().toStdString(), frame_every));
  }
  show_recording();
}

}  // namespace tetraction::viewer
