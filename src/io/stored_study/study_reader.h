// Reads a study from its directory.
#pragma once

#include <optional>
#include <string>

#include "io/study/study_run_files.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// A study and what its runs compute.
struct StoredPlan {
  StudyPlan plan;  ///< its variants have no scenes
  RunDigests digests;
};

/// A study as its study.json has it.
struct StoredStudy {
  StudyResult result;
  std::string scene;  ///< name of its file
  StudyProvenance provenance;
  std::string text;                  ///< of study.json
  std::optional<StoredPlan> plan{};  ///< not that of a program of its own
};

/// Reads the study.json of a directory, or a file with its text. Also that of a study that was interrupted. Throws FileError if it is missing,
/// cut off, of another kind or version, or contradicts itself: nothing in it is guessed.
StoredStudy read_stored_study(const std::string& path);

}  // namespace tetraction
