// What the window writes: scenes, pictures, frames.
#include <QAction>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QStatusBar>
#include <QThreadPool>

#include "body_view.h"
#include "live_chart.h"
#include "main_window.h"
#include "run_files.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction::viewer {

void MainWindow::ask_save_scene() {
  const QString path =
      QFileDialog::getSaveFileName(this, tr("Save the scene with all edits as events"),
                                   QStringLiteral("recorded.toml"), tr("Scenes (*.toml)"));
  if (!path.isEmpty()) save_scene(path);
}

void MainWindow::save_scene(const QString& path) {
  try {
    write_scene(simulation_->recorded_scene(), path.toLocal8Bit().toStdString());
    statusBar()->showMessage(tr("%1 is written: replay it with tetraction run.").arg(path), 8000);
  } catch (const Error& error) {
    messages_->show_message(MessageStrip::Kind::kError, QString::fromUtf8(error.what()));
  }
}

void MainWindow::ask_save_screenshot() {
  const QString path = QFileDialog::getSaveFileName(
      this, tr("Save what the view shows"), QStringLiteral("body.png"), tr("Pictures (*.png)"));
  if (path.isEmpty()) return;
  if (view_->picture().save(path)) {
    statusBar()->showMessage(tr("%1 is written.").arg(path), 8000);
  } else {
    messages_->show_message(MessageStrip::Kind::kError,
                            tr("%1: cannot be written. Choose another folder.").arg(path));
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
  if (!picture_folder_.isEmpty()) {
    statusBar()->showMessage(
        tr("%1 pictures are in %2.").arg(pictures_recorded_).arg(picture_folder_), 8000);
  }
  picture_folder_.clear();
  show_recording();
}

// The marks in the menu, without asking anything.
void MainWindow::show_recording() {
  const QSignalBlocker quiet_pictures(record_pictures_);
  const QSignalBlocker quiet_run(record_run_);
  record_pictures_->setChecked(!picture_folder_.isEmpty());
  record_run_->setChecked(run_files_ != nullptr);
}

void MainWindow::record_pictures(const QString& folder) {
  picture_folder_ = folder;
  pictures_recorded_ = 0;
  show_recording();
}

void MainWindow::record_picture() {
  const QString path =
      QDir(picture_folder_)
          .filePath(
              QStringLiteral("picture_%1.png").arg(++pictures_recorded_, 6, 10, QLatin1Char('0')));
  // Compressing takes longer than drawing: not in the window's thread.
  QThreadPool::globalInstance()->start([image = view_->picture(), path] { image.save(path); });
}

void MainWindow::ask_record_run(bool on) {
  const QString folder =
      on ? QFileDialog::getExistingDirectory(this, tr("Empty folder for frames.pvd, history.csv"))
         : QString();
  if (folder.isEmpty()) {
    stop_run_files();
  } else {
    record_run(folder);
  }
}

void MainWindow::stop_run_files() {
  if (run_files_) {
    try {
      run_files_->write_history(chart_->rows());
      statusBar()->showMessage(tr("%1 frames are in %2.")
                                   .arg(static_cast<qlonglong>(run_files_->frame_count()))
                                   .arg(QString::fromStdString(run_files_->directory())),
                               8000);
    } catch (const Error& error) {
      messages_->show_message(MessageStrip::Kind::kError, QString::fromUtf8(error.what()));
    }
  }
  run_files_.reset();
  show_recording();
}

void MainWindow::stop_recording() {
  stop_pictures();
  stop_run_files();
}

void MainWindow::record_run(const QString& folder) {
  if (QFileInfo::exists(QDir(folder).filePath(QStringLiteral("frames.pvd")))) {
    messages_->show_message(
        MessageStrip::Kind::kError,
        tr("%1: there is a run in it already, which would be lost. Choose an empty folder.")
            .arg(folder));
    show_recording();
    return;
  }
  try {
    run_files_ =
        std::make_unique<RunFiles>(simulation_->mesh(), folder.toLocal8Bit().toStdString());
  } catch (const Error& error) {
    messages_->show_message(MessageStrip::Kind::kError, QString::fromUtf8(error.what()));
  }
  recorded_generation_ = 0;
  show_recording();
}

void MainWindow::record_frame(const Snapshot& snapshot) {
  if (snapshot.generation == recorded_generation_) return;
  recorded_generation_ = snapshot.generation;
  try {
    run_files_->write(snapshot);
  } catch (const Error& error) {
    run_files_.reset();
    show_recording();
    messages_->show_message(MessageStrip::Kind::kError, QString::fromUtf8(error.what()));
  }
}

}  // namespace tetraction::viewer
