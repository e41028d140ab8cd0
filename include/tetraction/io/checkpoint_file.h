// Files with checkpoints, from which another program goes on with a run.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// How far the files of a run (io/run_recorder.h) were written at a checkpoint.
struct RecordedFiles {
  std::uint64_t history_size = 0;          ///< of history.csv, bytes
  Index last_row = -1;                     ///< the step of its last row
  std::uint64_t probes_size = 0;           ///< of probes.csv, bytes; 0: there is none
  Index last_probe_row = -1;               ///< the step of its last row
  Index last_frame = -1;                   ///< the step of the last frame
  std::uint32_t history_sum = 0;           ///< CRC-32 of these bytes of history.csv
  std::uint32_t probes_sum = 0;            ///< CRC-32 of these bytes of probes.csv
  std::vector<std::uint64_t> frame_sizes;  ///< of the files that frames.pvd names, bytes
};

/// The inputs of a run. A part of it that differs can be named.
struct RunInputs {
  std::string scene;  ///< Scene::echo; empty for the scene of a program
  std::uint64_t numbers =
      0;                     ///< made from the numbers of vertices and tetrahedra in the mesh file,
                             ///< and from its groups
  std::uint64_t fields = 0;  ///< made from TetMesh::point_arrays
  std::uint64_t amplitudes = 0;  ///< made from the tables of the amplitudes
  std::uint64_t surfaces = 0;    ///< made from the surfaces of obstacles
};

/// The inputs of a session. The mesh itself is in Checkpoint::body.
RunInputs inputs_of(const Session& session);

/// The number of processes that make the run of a session together.
int process_count(const Session& session);

/// The keys of the scenes whose values differ, as in "time.step" or "force.0.vector". The order of keys
/// does not count, and neither do [output] and solver.engine, which do not affect the motion, and the paths of
/// files, whose contents are compared instead.
std::vector<std::string> changed_keys(const std::string& scene, const std::string& other);

/// A checkpoint with what belongs to the program that made it.
struct StoredCheckpoint {
  std::string version;      ///< of the program
  bool is_regular = false;  ///< see CheckpointObserver
  int processes = 1;        ///< that made the run together
  RunInputs inputs;
  PhaseTimes times;
  RecordedFiles files;
  /// checkpoint_from_bytes() fills everything but the settings. Of these it fills the objects of
  /// constraints; complete_settings() gives the rest.
  Checkpoint checkpoint;
};

/// Whether a file can have this checkpoint: only the events of its scene have edited the run.
bool can_be_stored(const Checkpoint& checkpoint);

/// The contents of a checkpoint file: a text that names it, the version of the format, the size, the
/// numbers, and a check sum (CRC-32) of all that, in the byte order of the machine. Settings are not stored, because
/// the scene and its events give them. Throws InputError unless can_be_stored().
std::string checkpoint_bytes(const StoredCheckpoint& stored);
/// Reads what checkpoint_bytes() wrote. Nothing in `bytes` is trusted. Throws FileError, which begins
/// with `name`, if it is not such a file, or not a whole one, or of another format or byte order.
StoredCheckpoint checkpoint_from_bytes(std::string_view bytes, const std::string& name);

/// Fills the settings from the scene and the events that were made. A run that was cancelled goes on.
/// Throws InputError if the constraints are not those of the scene.
void complete_settings(Checkpoint& checkpoint, const Scene& scene);

/// A checkpoint file of a run.
struct CheckpointPath {
  std::string path;
  Index step = 0;           ///< by its name
  bool is_regular = false;  ///< by its name
};
/// The checkpoint files in the directory of a run, the newest first.
std::vector<CheckpointPath> checkpoint_paths(const std::string& directory);

/// Reads a file. Throws FileError, as checkpoint_from_bytes() does, and if it cannot be read.
StoredCheckpoint read_checkpoint_file(const std::string& path);

/// Writes a checkpoint into the directory of a run, as `checkpoints/step_NNNNNNNNN.ckpt`, or
/// `checkpoints/stop_NNNNNNNNN.ckpt` if it is not regular. The file is there as a whole or not at
/// all. Of the older ones only the newest regular one is kept, with which there are two. A folder of
/// that name, or of an older checkpoint's, is left alone; there is no checkpoint of its step then. Throws
/// OutputError.
void write_checkpoint_file(const std::string& directory, const StoredCheckpoint& stored);

/// Deletes the checkpoints that are newer than the one of this name, and unfinished ones. Throws
/// OutputError.
void remove_checkpoints_after(const std::string& directory, Index step, bool is_regular);

/// Deletes the checkpoints of an earlier run, and the folder if nothing else is in it. Throws
/// OutputError.
void remove_checkpoints(const std::string& directory);

}  // namespace tetraction
