// Writes the results of a run in several processes.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tetraction/simulation/checkpoint_observer.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

struct StoredCheckpoint;

/// The counterpart of RunRecorder for a session of a body in parts (TetMesh::part). Each process has one.
/// Process 0 writes history.csv, probes.csv and summary.json as RunRecorder does. Frames, and final.pvtu in
/// place of final.vtu, are in pieces: every process writes its own (PVTU).
///
/// All processes must run the session with their recorder. lock_directory(), resume(), on_start() and on_finish() throw OutputError in all
/// of them, on_finish() after it has written final.pvtu and summary.json if that is possible. on_step() does not:
/// the processes have to ask has_failed() after each step, and end the run together.
class PartRecorder : public Observer, public CheckpointObserver {
 public:
  PartRecorder(std::string directory, int frame_every);
  ~PartRecorder() override;
  PartRecorder(const PartRecorder&) = delete;
  PartRecorder& operator=(const PartRecorder&) = delete;

  /// Sets the function that returns the exit code of a run that was stopped (RunStatus::kCancelled), for summary.json.
  void set_stop_code(std::function<int()> stop_code);

  /// As RunRecorder. The checkpoints are those of a run in one process: process 0 collects them, for which it needs
  /// memory for the state of the whole body, and any number of processes can go on from them.
  void lock_directory(const MeshPart& part);
  void keep_checkpoints(Index every);
  /// As RunRecorder::resume(); every process has its part of the checkpoint (handed_out()).
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

}  // namespace tetraction
