// tetraction run --resume
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tetraction/io/checkpoint_file.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// The results of --resume in the output directory.
enum class Resumption {
  kNothing,    ///< no checkpoint that can be used: the run starts from the beginning
  kContinues,  ///< session and recorder go on from a checkpoint
  kComplete    ///< the run is complete already
};

/// Where a run goes on.
struct ResumePoint {
  Resumption resumption = Resumption::kNothing;
  StoredCheckpoint stored;           ///< with kContinues
  std::vector<std::string> changes;  ///< inputs that have changed, with `force`
  bool has_new_steps = false;        ///< whether the keys of [time] are among them
};

/// Looks for the point in the directory. `body`: Session::checkpoint().body. Says so if there is none, or if the
/// run is complete. If the scene has output.checkpoint_every, only checkpoints that an uninterrupted run makes, too,
/// are used, so that the results have the same bits. A checkpoint that is not valid is reported, and the one before it
/// is used. With `force` scene and mesh may have changed; throws InputError if they have without it. Does not talk to
/// other processes.
ResumePoint find_resume_point(const Session& session, const BodyIdentity& body,
                              const std::string& directory, bool force);

/// Calls find_resume_point(), of several processes on the first one; the others return a point without anything.
using PointFinder = std::function<ResumePoint(const BodyIdentity& body)>;

/// Lets a session, which has just been made, and its recorder go on with the run whose results are in
/// `directory`, which is locked. Says what it does. Collective for a body in parts. Throws what `find` throws,
/// FileError if results were changed since the checkpoint, and OutputError.
Resumption resume_run(Session& session, RunRecorder& recorder, const std::string& directory,
                      bool quiet, const PointFinder& find);

/// The summary.json in a directory, or an empty text.
std::string read_summary(const std::string& directory);

}  // namespace tetraction
