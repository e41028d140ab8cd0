// The frames of a finished run, or of a mode that swings, as snapshots, which the window draws.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "viewer/analyses/stored_modes.h"
#include "viewer/gui/chart/chart_series.h"
#include "viewer/snapshot.h"

namespace tetraction::viewer {

/// Reads the directory of a run (frames.pvd, frames/, history.csv). Not thread-safe.
class Replay {
 public:
  /// `path`: the directory or its frames.pvd. Throws FileError.
  explicit Replay(const std::string& path);
  /// A mode that swings. The time of a frame is the part of the period. Throws FileError.
  Replay(const StoredModes& modes, std::size_t mode);

  const std::string& directory() const { return directory_; }
  const TetMesh& mesh() const { return mesh_; }
  /// Whether it is a motion, the computation of an equilibrium, or a mode.
  RunKind kind() const { return kind_; }
  /// The times of the frames, s, the load factors of an equilibrium, or the parts of the period of a mode.
  const std::vector<double>& times() const { return times_; }
  /// The frame that is nearest to a time.
  std::size_t frame_at(double time) const;
  /// The motion of a mode, which may be changed; null for a run.
  ModeMotion* motion() { return motion_ ? &*motion_ : nullptr; }
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
  Snapshot snapshot_at(std::size_t i) const;
  std::shared_ptr<const ObstacleSurface> obstacles_at(std::size_t i) const;
  std::shared_ptr<const Snapshot> frame_of_mode(std::size_t i, ColorField field) const;

  std::string directory_;
  std::vector<double> times_;
  std::vector<std::string> files_;
  std::vector<std::string> obstacle_files_;  // of each frame; empty without obstacles
  // The obstacles that were read last, which many frames have in common.
  mutable std::string obstacles_from_;
  mutable std::shared_ptr<const ObstacleSurface> obstacles_;
  TetMesh mesh_;
  Vector rest_;
  std::optional<ModeMotion> motion_;
  RunKind kind_ = RunKind::kMotion;
  std::vector<HistoryRow> history_;
  std::vector<ChartProbe> probes_;
};

}  // namespace tetraction::viewer
