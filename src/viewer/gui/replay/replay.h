// The frames of a finished run as snapshots, which the window draws.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "viewer/gui/chart/chart_series.h"
#include "viewer/snapshot.h"

namespace tetraction::viewer {

/// Reads the directory of a run (frames.pvd, frames/, history.csv). Not thread-safe.
class Replay {
 public:
  /// `path`: the directory or its frames.pvd. Throws FileError.
  explicit Replay(const std::string& path);

  const std::string& directory() const { return directory_; }
  const TetMesh& mesh() const { return mesh_; }
  /// Whether the run is a motion or the computation of an equilibrium.
  RunKind kind() const { return kind_; }
  /// The times of the frames, s, or the load factors of an equilibrium.
  const std::vector<double>& times() const { return times_; }
  /// Frame i as a snapshot, coloured by `field`. Throws FileError.
  std::shared_ptr<const Snapshot> frame(std::size_t i, ColorField field) const;
  /// All rows of history.csv, with the values of probes.csv. A step that only probes.csv has is a row
  /// whose other numbers are NaN, and so are the numbers of a motion in an equilibrium. Empty if the
  /// files do not exist.
  const std::vector<HistoryRow>& history() const { return history_; }
  /// The probes of probes.csv.
  const std::vector<ChartProbe>& probes() const { return probes_; }

 private:
  void read_collection(const std::string& path);
  void read_history(const std::string& path);
  void read_probes(const std::string& path);

  std::string directory_;
  std::vector<double> times_;
  std::vector<std::string> files_;
  TetMesh mesh_;
  Vector rest_;
  RunKind kind_ = RunKind::kMotion;
  std::vector<HistoryRow> history_;
  std::vector<ChartProbe> probes_;
};

}  // namespace tetraction::viewer
