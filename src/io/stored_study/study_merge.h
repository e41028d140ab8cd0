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
  [[noreturn]] void fail(std::size_t other, const std::string& what) const;
  void require_same_study(std::size_t other) const;
  void join_runs();
  void choose_references();
  std::size_t place_of(const std::string& directory) const;
  std::optional<StudyRow> row(std::size_t run) const;
  TrackSource tracks() const;

  std::vector<std::string> directories_;
  std::vector<StoredStudy> studies_;
  StudyPlan plan_;
  std::vector<std::string> folders_;  // of the runs of the plan; empty if nobody made the run
  std::string mesh_check_folder_;     // of the run on a finer mesh, if there is one
  StudyResult result_;
};

}  // namespace tetraction
