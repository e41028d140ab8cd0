// Saves scenes, and records pictures and runs.
#include <QAction>
#include <QDir>
#include <QElapsedTimer>
#include <QFileDialog>
#include <QFileInfo>
#include <QInputDialog>
#include <QLabel>
#include <QLineEdit>
#include <QLocale>
#include <QProcess>
#include <QSaveFile>
#include <QStandardPaths>
#include <QStatusBar>
#include <QThreadPool>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "main_window.h"
#include "tetraction/core/error.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_writer.h"
#include "viewer/gui/body/body_view.h"
#include "viewer/gui/results/comparison.h"
#include "viewer/gui/scene/scene_panels.h"
#include "viewer/gui/transport/transport_bar.h"

namespace tetraction::viewer {
namespace {

constexpr int kMostWaiting = 16;            // largest number of pictures in the queue
constexpr double kRate = 25.0;              // pictures in a second of a film
constexpr qint64 kMostBytes = 100'000'000;  // that wait for ffmpeg
constexpr int kPatience_ms = 10'000;        // with an ffmpeg that makes no progress

bool is_film(const QString& path) {
  return path.endsWith(QLatin1String(".webm"), Qt::CaseInsensitive) ||
         path.endsWith(QLatin1String(".mp4"), Qt::CaseInsensitive);
}

QString ffmpeg() {
  return QStandardPaths::findExecutable(QStringLiteral("ffmpeg"));
}

// A process that makes a film of pictures of this size, which it reads as bytes of red, green and blue.
std::unique_ptr<QProcess> start_film(const QString& path, const QSize& size, double rate) {
  const bool is_webm = path.endsWith(QLatin1String(".webm"), Qt::CaseInsensitive);
  auto process = std::make_unique<QProcess>();
  process->setStandardOutputFile(QProcess::nullDevice());
  process->start(ffmpeg(), {"-loglevel",
                            "error",
                            "-y",
                            "-f",
                            "rawvideo",
                            "-pix_fmt",
                            "rgb24",
                            "-s",
                            QStringLiteral("%1x%2").arg(size.width()).arg(size.height()),
                            "-r",
                            QString::number(rate, 'g', 6),
                            "-i",
                            "-",
                            "-an",
                            "-pix_fmt",
                            "yuv420p",
                            "-c:v",
                            is_webm ? "libvpx-vp9" : "libx264",
                            "-crf",
                            is_webm ? "24" : "18",
                            path});
  process->waitForStarted();
  return process;
}

QString picture_path(const QString& folder, std::size_t number) {
  return QDir(folder).filePath(
      QStringLiteral("picture_%1.png").arg(number, 6, 10, QLatin1Char('0')));
}

// Makes a folder whose name is typed, which Qt's dialog would refuse.
class FolderDialog : public QFileDialog {
 public:
  using QFileDialog::QFileDialog;

 protected:
  void accept() override {
    const auto* name = findChild<QLineEdit*>(QStringLiteral("fileNameEdit"));
    if (name != nullptr && !name->text().isEmpty()) directory().mkpath(name->text());
    QFileDialog::accept();
  }
};

// Empty if the user wants none.
QString ask_folder(QWidget* parent, const QString& title) {
  FolderDialog dialog(parent, title);
  dialog.setFileMode(QFileDialog::Directory);
  dialog.setOption(QFileDialog::ShowDirsOnly);
  dialog.setOption(QFileDialog::DontUseNativeDialog);
  if (dialog.exec() != QDialog::Accepted) return {};
  return dialog.selectedFiles().value(0);
}

QString ask_scene_path(QWidget* parent) {
  return QFileDialog::getSaveFileName(
      parent, MainWindow::tr("Save the scene with all edits as events"),
      QStringLiteral("recorded.toml"), MainWindow::tr("Scenes (*.toml)"));
}

// Waits until ffmpeg has made a film of all pictures. Kills it, and returns false, when it makes no progress any more.
bool wait_for_end(QProcess& ffmpeg, const QString& film) {
  constexpr int kLook_ms = 200;
  qint64 last = -1;
  QElapsedTimer since_progress;
  since_progress.start();
  while (ffmpeg.state() != QProcess::NotRunning && !ffmpeg.waitForFinished(kLook_ms)) {
    // The pictures that wait become fewer, or the film grows.
    const qint64 now = QFileInfo(film).size() - ffmpeg.bytesToWrite();
    if (now != last) since_progress.restart();
    last = now;
    if (since_progress.elapsed() < kPatience_ms) continue;
    ffmpeg.kill();
    ffmpeg.waitForFinished();
    return false;
  }
  return true;
}

}  // namespace

/// Pictures that are being written to the disk, or to a film.
struct PictureQueue {
  QSize size;  // empty: that of the view
  std::unique_ptr<QProcess> film{};
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
  unsaved_.forget();
  return true;
}

void MainWindow::keep_unsaved_edits() {
  if (!simulation_) return;
  if (!has_unsaved_edits()) return unsaved_.forget();
  const std::size_t edits = simulation_->edit_count();
  if (std::exchange(kept_edits_, edits) == edits) return;
  try {
    unsaved_.keep(simulation_->recorded_scene(), scene_->off(),
                  path_.isEmpty() ? path_ : QFileInfo(path_).absoluteFilePath());
  } catch (const Error& error) {
    statusBar()->showMessage(
        tr("The edits are not kept for the case of a crash: %1").arg(error.what()), 8000);
  }
}

void MainWindow::offer_unsaved_edits() {
  for (UnsavedScene& scene : unsaved_scenes()) {
    offer(std::make_shared<UnsavedScene>(std::move(scene)));
  }
}

void MainWindow::offer(const std::shared_ptr<UnsavedScene>& unsaved) {
  const QString name = QFileInfo(unsaved->document).fileName();
  messages_->show_message(
      MessageStrip::Kind::kWarning,
      tr("The program ended before the edits of %1 were saved. They are kept as they were at %2.")
          .arg(name.isEmpty() ? tr("the first scene") : name,
               QLocale().toString(unsaved->time, QLocale::ShortFormat)),
      unsaved->file,
      {{tr("Restore"), [this, unsaved] { restore(unsaved); }},
       {tr("Discard"), [unsaved] { unsaved->discard(); }}});
}

void MainWindow::restore(const std::shared_ptr<UnsavedScene>& unsaved) {
  if (opening() || !may_lose_edits()) return offer(unsaved);
  restoring_ = unsaved;
  begin_opening(unsaved->file, std::async(std::launch::async, open_unsaved,
                                          unsaved->file.toLocal8Bit().toStdString(),
                                          unsaved->document.toLocal8Bit().toStdString()));
}

bool MainWindow::write(const Scene& scene, const QString& path) {
  try {
    write_scene(scene, scene_->off(), path.toLocal8Bit().toStdString());
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
  QSaveFile file(path);  // keeps an earlier picture if it fails
  if (file.open(QIODevice::WriteOnly) && comparison_->picture().save(&file, "PNG") &&
      file.commit()) {
    statusBar()->showMessage(tr("%1 is written.").arg(path), 8000);
  } else {
    show_error(
        tr("%1: cannot be written (%2). Choose another folder.").arg(path, file.errorString()));
  }
}

void MainWindow::ask_record_pictures(bool on) {
  const QString folder =
      on ? ask_folder(this, tr("Folder for picture_000001.png and so on")) : QString();
  if (folder.isEmpty()) {
    stop_pictures();
  } else {
    record_pictures(folder);
  }
}

// Asks for the file and the size of a film.
void MainWindow::ask_record_film() {
  const QString path = QFileDialog::getSaveFileName(
      this, tr("Record a film"), QStringLiteral("film.webm"), tr("Films (*.webm *.mp4)"));
  if (path.isEmpty()) return;
  const std::vector<QSize> sizes{{}, {1280, 720}, {1920, 1080}, {3840, 2160}};
  QStringList names{tr("as the view")};
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    names += tr("%1 × %2").arg(sizes[i].width()).arg(sizes[i].height());
  }
  bool accepted = false;
  const QString name =
      QInputDialog::getItem(this, tr("Record a film"), tr("Size"), names, 0, false, &accepted);
  if (!accepted) return;
  record_pictures(is_film(path) ? path : path + QStringLiteral(".webm"),
                  sizes[static_cast<std::size_t>(names.indexOf(name))]);
}

void MainWindow::stop_pictures() {
  if (picture_folder_.isEmpty()) {
    show_recording();
    return;
  }
  QThreadPool::globalInstance()->waitForDone();
  if (QProcess* film = picture_queue_->film.get()) {
    film->closeWriteChannel();
    const bool ended = wait_for_end(*film, picture_folder_);
    picture_queue_->failed = picture_queue_->failed || !ended || film->exitCode() != 0 ||
                             film->exitStatus() != QProcess::NormalExit;
  }
  const QString folder = std::exchange(picture_folder_, QString());
  if (simulation_) simulation_->set_picture_interval(0.0);
  show_recording();
  if (picture_queue_->film && picture_queue_->failed) {
    const QString reason =
        QString::fromLocal8Bit(picture_queue_->film->readAllStandardError()).trimmed();
    show_error(tr("%1: ffmpeg could not make the film. %2 Choose another file, or record pictures.")
                   .arg(folder, reason.section(QLatin1Char('\n'), 0, 0)));
  } else if (picture_queue_->failed) {
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
  record_film_->setEnabled(picture_folder_.isEmpty() && !ffmpeg().isEmpty());
  QStringList what;
  if (!run_folder_.isEmpty()) what += tr("run");
  if (!picture_folder_.isEmpty()) what += is_film(picture_folder_) ? tr("film") : tr("pictures");
  status_recording_->setText(tr("● recording: %1").arg(what.join(QLatin1String(", "))));
  status_recording_->setToolTip(
      QStringList{run_folder_, picture_folder_}.join(QLatin1Char('\n')).trimmed());
  status_recording_->setVisible(!what.isEmpty());
  comparison_->set_recording(!picture_folder_.isEmpty());
}

void MainWindow::record_pictures(const QString& path, const QSize& size) {
  stop_pictures();
  const bool film = is_film(path);
  if (film && ffmpeg().isEmpty()) {
    show_error(tr("%1: films need the program ffmpeg, which is not installed. Record pictures.")
                   .arg(path));
  } else if (!film && QFileInfo::exists(picture_path(path, 1))) {
    show_error(tr("%1: there are pictures in it already, which would be lost. Choose an empty "
                  "folder.")
                   .arg(path));
  } else if (!film && !QDir().mkpath(path)) {
    show_error(tr("%1: cannot be made. Choose another folder.").arg(path));
  } else {
    picture_folder_ = path;
    pictures_recorded_ = 0;
    picture_queue_ = std::make_shared<PictureQueue>();
    picture_queue_->size = size;
    next_picture_ = -1.0;
    double rate = kRate;
    if (simulation_) {
      // At the speed that is set. Longer steps have a picture each.
      const double speed = transport_->speed() > 0.0 ? transport_->speed() : 1.0;
      picture_interval_ = std::max(speed / kRate, simulation_->settings().time.step);
      rate = speed / picture_interval_;
      simulation_->set_picture_interval(picture_interval_);
    }
    if (film) {
      // Films need even numbers of pixels.
      const QSize all = size.isEmpty() ? comparison_->picture().size() : size;
      picture_queue_->size = QSize(all.width() & ~1, all.height() & ~1);
      picture_queue_->film = start_film(path, picture_queue_->size, rate);
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
  const QImage picture = comparison_->picture(picture_queue_->size);
  if (QProcess* film = picture_queue_->film.get()) {
    const QImage rgb = picture.convertToFormat(QImage::Format_RGB888);
    for (int y = 0; y < rgb.height(); ++y) {
      film->write(reinterpret_cast<const char*>(rgb.constScanLine(y)), 3 * rgb.width());
    }
    while (film->bytesToWrite() > kMostBytes && film->waitForBytesWritten()) {
    }
    ++pictures_recorded_;
    if (film->state() == QProcess::NotRunning) picture_queue_->failed = true;
    return;
  }
  auto save = [image = picture, queue = picture_queue_,
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
    folder = ask_folder(this, tr("Empty folder for frames.pvd, history.csv, summary.json"));
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
