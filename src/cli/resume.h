// tetraction run --resume
#pragma once

#include <string>

#include "tetraction/io/run_recorder.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// What --resume found in the output directory.
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

/// The summary.json in a directory, or an empty text.
std::string read_summary(const std::string& directory);

}  // namespace tetraction
