// Joins studies of the same scene: parts of one study, or studies with other steps and rules.
#pragma once

#include <string>
#include <vector>

#include "study_reader.h"

namespace tetraction {

/// The runs of several studies as one study, which writes nothing by itself.
class MergedStudy {
 public:
  /// Reads the studies and compares all their runs with the finest of their references. A run that several studies
  /// have is that of the first one. Throws InputError if the studies do not belong together, and FileError if one
  /// of them, or a run of it, cannot be read.
  explicit MergedStudy(const std::vector<std::string>& directories);

  const StudyResult& result() const { return result_; }
  const std::string& scene() const { return studies_.front().scene; }
  /// StudyProvenance::plan.
  std::string plan() const;

  /// Copies everything but frames of all runs into a directory, in which later studies know them again. Throws
  /// OutputError, and FileError for a run that cannot be read.
  void copy_runs(const std::string& directory) const;

 private:
  struct Source {
    std::string folder;  // path of the run's results
    std::optional<StudyRow> row;
  };

  void require_same_study(std::size_t other) const;
  void join_runs();
  void choose_references();
  void read_rows();
  TrackSource tracks() const;

  std::vector<std::string> directories_;
  std::vector<StoredStudy> studies_;
  StudyPlan plan_;
  std::vector<Source> sources_;  // of the runs of the plan
  StudyResult result_;
};

/// A directory that gets its name only when it is complete. It must not be there before, or be empty. All
/// functions throw OutputError; the constructor throws InputError for a directory with something in it.
class ReplacementDirectory {
 public:
  explicit ReplacementDirectory(std::string path);
  /// Deletes the temporary directory unless it has been renamed.
  ~ReplacementDirectory();
  ReplacementDirectory(const ReplacementDirectory&) = delete;
  ReplacementDirectory& operator=(const ReplacementDirectory&) = delete;

  const std::string& temporary() const { return temporary_; }
  /// Gives the directory its name.
  void finish();

 private:
  std::string path_;
  std::string temporary_;
};

}  // namespace tetraction
