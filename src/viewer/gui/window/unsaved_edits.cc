#include "unsaved_edits.h"

#include <QCoreApplication>
#include <QDir>
#include <QFile>
#include <QFileInfo>
#include <QSettings>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/io/scene_writer.h"
#include "tetraction/io/text_file.h"

namespace tetraction::viewer {
namespace {

// The first line of a file, before the path of the document.
const QString kTitle = QStringLiteral("# Unsaved edits of ");

QDir folder() {
  return {QFileInfo(QSettings().fileName()).dir().filePath(QStringLiteral("unsaved"))};
}

// Null if a window that runs has it. The lock of a process that has ended counts for nothing.
std::unique_ptr<QLockFile> lock_of(const QString& file) {
  auto lock = std::make_unique<QLockFile>(file + QStringLiteral(".lock"));
  lock->setStaleLockTime(0);
  return lock->tryLock() ? std::move(lock) : nullptr;
}

}  // namespace

void UnsavedScene::discard() {
  QFile::remove(file);
  lock.reset();
}

std::vector<UnsavedScene> unsaved_scenes() {
  std::vector<UnsavedScene> found;
  for (const QFileInfo& info :
       folder().entryInfoList({QStringLiteral("*.toml")}, QDir::Files, QDir::Time)) {
    UnsavedScene scene{info.filePath(), {}, info.lastModified(), lock_of(info.filePath())};
    QFile file(scene.file);
    if (!scene.lock || !file.open(QIODevice::ReadOnly)) continue;
    const QString line = QString::fromUtf8(file.readLine()).trimmed();
    if (line.startsWith(kTitle.trimmed())) scene.document = line.mid(kTitle.size());
    found.push_back(std::move(scene));
  }
  return found;
}

void UnsavedEdits::keep(const Scene& scene, const std::vector<OffEntry>& off,
                        const QString& document) {
  if (!scene_.lock) {
    folder().mkpath(QStringLiteral("."));
    const qint64 process = QCoreApplication::applicationPid();
    for (int number = 1; !scene_.lock; ++number) {
      scene_.file = folder().filePath(QStringLiteral("%1-%2.toml").arg(process).arg(number));
      if (QFile::exists(scene_.file)) continue;
      scene_.lock = lock_of(scene_.file);
      constexpr int kMostWindows = 1000;
      if (number > kMostWindows)
        throw OutputError(scene_.file.toStdString() + ": cannot be locked.");
    }
  }
  const QString text = kTitle + document + QLatin1Char('\n');
  write_text_file(scene_.file.toLocal8Bit().toStdString(),
                  text.toStdString() +
                      scene_text(scene, folder().path().toLocal8Bit().toStdString()) +
                      off_entries_text(off));
}

void UnsavedEdits::forget() {
  if (scene_.lock) scene_.discard();
}

}  // namespace tetraction::viewer
