// tetraction run --resume
#pragma once

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

/// Lets a session, which has just been made, and its recorder go on with the run whose results are in
/// `directory`, which is locked. Says what it does. If the scene has output.checkpoint_every, only
/// checkpoints that an uninterrupted run makes, too, are used, so that the results have the same
/// bits. A checkpoint that is not valid is reported, and the one before it is used. With `force`
/// scene and mesh may have changed. Throws InputError if they have without it, FileError if results
/// were changed since the checkpoint, and OutputError.
Resumption resume_run(Session& session, RunRecorder& recorder, const std::string& directory,
                      bool force, bool quiet);

// resume_run() in steps, between which several processes hand out the checkpoint.

/// Where a run goes on.
struct ResumePoint {
  Resumption resumption = Resumption::kNothing;
  StoredCheckpoint stored;           ///< with kContinues
  std::vector<std::string> changes;  ///< inputs that have changed, with `force`
  bool has_new_steps = false;        ///< whether the keys of [time] are among them
};

/// Looks for the point in the directory. `body`: Session::checkpoint().body. Says so if there is none, or if the
/// run is complete. Throws as resume_run(). Does not talk to other processes.
ResumePoint find_resume_point(const Session& session, const BodyIdentity& body,
                              const std::string& directory, bool force);
/// Restores the session.
void restore_run(Session& session, const BodyIdentity& body, ResumePoint& point);
/// Tells the user where the run goes on, and what may differ from one run.
void report_resumption(const Session& session, const ResumePoint& point,
                       const std::string& directory, bool quiet);

/// The summary.json in a directory, or an empty text.
std::string read_summary(const std::string& directory);

}  // namespace tetraction
