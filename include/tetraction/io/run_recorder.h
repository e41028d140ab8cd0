// Writes the results of a run: history.csv, frames, final.vtu, summary.json.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tetraction/simulation/checkpoint_observer.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

class ProbeTraces;
struct StoredCheckpoint;

/// Observer that writes the outputs of `run` into a directory, which it makes if there is none:
///
/// - history.csv: one row for the initial state and each step, 17 significant digits. Work and
///   dissipation columns are sums from the start, so that in every row
///   total_energy − total_energy(0) = external_work − dissipated_energy + constraint_work +
///   edit_work + energy_error. With output.history_every = n there are rows for each n-th step, the
///   first and the last only;
/// - probes.csv, if the scene has probes: a row for the initial state and for each step at which a
///   probe is due;
/// - frames/frame_NNNNNN.vtu and frames.pvd: every `frame_every`-th step, the first and the last,
///   with the fields and in the format that the scene's [output] says. With frame_every = 0 there
///   are none;
/// - final.vtu: the last good state in full precision, with the same fields;
/// - summary.json: at the end.
///
/// Whenever the program ends, also when it is killed, what is there is complete: history.csv and
/// probes.csv end with a whole row, other files are there as a whole or not at all, and frames.pvd
/// names only frames that are there and whose rows history.csv has. If something cannot be written,
/// OutputError is thrown, after final.vtu and summary.json have been written if that is possible.
///
/// From on_start() to on_finish() no other recorder can write into the directory
/// (lock_directory()). Files of an earlier run are replaced, links by files; `frames` must not be a
/// link. on_start() throws InputError, before anything is written, if one of these files is an input of the
/// session: its scene, its mesh, or a table.
///
/// If the body is in parts (TetMesh::part), each process has a recorder, and all of them must run the session with it.
/// Process 0 writes history.csv, probes.csv, summary.json and checkpoints as above; for a checkpoint it needs memory
/// for the state of the whole body. Frames, and final.pvtu in place of final.vtu, are in pieces (FrameWriter).
/// lock_directory(), resume(), on_start() and on_finish() throw OutputError in all processes. on_step() does not: the
/// processes have to ask has_failed() after each step, and end the run together.
class RunRecorder : public Observer, public CheckpointObserver {
 public:
  RunRecorder(std::string directory, int frame_every);
  ~RunRecorder() override;
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  /// Makes the directory, and keeps others from writing there until on_finish(). on_start() does this
  /// anyway. Throws OutputError if another run writes there. `part`: that of the session's mesh.
  void lock_directory(const MeshPart* part = nullptr);
  /// Sets the function that returns the exit code of a run that was stopped (RunStatus::kCancelled), for summary.json.
  /// By default it is that of exit_code().
  void set_stop_code(std::function<int()> stop_code);

  /// Stores checkpoints (io/checkpoint_file.h) after each so many steps, and one if the run is
  /// cancelled; with 0 only that one. A run with other edits than the events of its scene has none, because
  /// nobody could repeat its edits: leaves_out_checkpoints() then is true from the first one on, and earlier
  /// ones are deleted. All other files are complete.
  void keep_checkpoints(Index every);
  bool leaves_out_checkpoints() const;
  /// Goes on with the files of an earlier part of the run, which was restored from this checkpoint:
  /// what they have beyond it is removed. To be called after Session::restore() and before the
  /// run, with the directory locked; each process has its part of the checkpoint (scattered()). Throws FileError, before anything is changed, if the files are
  /// not as they were at the checkpoint, and OutputError.
  void resume(const Session& session, const StoredCheckpoint& stored);

  Index checkpoint_every() const override;
  void on_checkpoint(const Session& session, const Checkpoint& checkpoint,
                     bool is_regular) override;
  void on_start(const Session& session) override;
  bool on_step(const Session& session) override;
  void on_finish(const Session& session) override;
  /// Whether something could not be written, or a process knows of another one that could not.
  bool has_failed() const;
  /// The text of summary.json. Empty before on_finish().
  const std::string& summary() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How a run ended, for summary.json.
struct RunEnd {
  std::string status;   ///< to_string(RunStatus), or "failed" if something could not be written
  int exit_status = 0;  ///< of the program
  std::string message;
};

/// The text of summary.json for a run whose results go to `directory`. If the traces of its probes
/// are given, the text says what dominates them. Without `end` the session says how it ended.
std::string summary_json(const Session& session, const std::string& directory,
                         const ProbeTraces* probes = nullptr, const RunEnd* end = nullptr);

/// Makes a directory and its parents; throws OutputError if it cannot be made or written to.
void make_output_directory(const std::string& directory);

}  // namespace tetraction
