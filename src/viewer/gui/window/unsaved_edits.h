// Edits that are not saved, in a file that outlives a crash of the program.
#pragma once

#include <QDateTime>
#include <QLockFile>
#include <QString>
#include <memory>
#include <vector>

#include "document/off_entries.h"

namespace tetraction::viewer {

/// A scene with unsaved edits in a folder beside the settings of the program. A lock belongs to it, which no other
/// window has as long as this object lives.
struct UnsavedScene {
  QString file;
  QString document;  ///< the path of what was opened; empty for the first scene
  QDateTime time;    ///< when it was written
  std::unique_ptr<QLockFile> lock;

  /// Removes the file.
  void discard();
};

/// The scenes that windows have left that do not run any more, the newest first.
std::vector<UnsavedScene> unsaved_scenes();

/// The unsaved edits of one window.
class UnsavedEdits {
 public:
  UnsavedEdits() = default;
  ~UnsavedEdits() { forget(); }
  UnsavedEdits(const UnsavedEdits&) = delete;
  UnsavedEdits& operator=(const UnsavedEdits&) = delete;

  /// Writes the scene with its edits. Throws InputError for a scene that a file cannot hold, and OutputError.
  void keep(const Scene& scene, const std::vector<OffEntry>& off, const QString& document);
  /// Removes the file, because the edits are saved or nobody wants them.
  void forget();

 private:
  UnsavedScene scene_;
};

}  // namespace tetraction::viewer
