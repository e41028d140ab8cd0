// Writes what is shown as a run's directory that ParaView and the replay open.
#pragma once

#include <string>
#include <vector>

#include "tetraction/io/frame_writer.h"
#include "viewer/snapshot.h"

namespace tetraction::viewer {

/// frames/, frames.pvd, and at the end history.csv. Frames hold positions, momenta, forces and the
/// field that colours the body. All functions throw OutputError.
class RunFiles {
 public:
  RunFiles(const TetMesh& mesh, const std::string& directory);

  void write(const Snapshot& snapshot);
  void write_history(const std::vector<HistoryRow>& rows) const;
  const std::string& directory() const { return directory_; }
  Index frame_count() const { return frames_.frame_count(); }

 private:
  std::string directory_;
  Vector rest_;
  FrameWriter frames_;
};

/// The cell array of a frame that holds a field, or null for fields of vertices: these follow from what
/// a frame has anyway.
const char* cell_array_name(ColorField field);

/// history.csv of the rows: the columns of `tetraction run` that a history has.
std::string history_text(const std::vector<HistoryRow>& rows);

}  // namespace tetraction::viewer
