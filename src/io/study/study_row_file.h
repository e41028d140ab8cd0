// The result of one run of a study in a file of its own, so that a study can go on after it was
// stopped.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The name of the file in the folder of a run.
inline constexpr const char* kStudyRowFile = "study_row.json";

/// What the results of the runs of a study depend on. [output] does not count.
class StudyInputs {
 public:
  StudyInputs(const StudyPlan& plan, const TetMesh& mesh);

  /// Of the runs of a variant: program version, scene, mesh, end, error probe, steps, and the scenes,
  /// meshes and runs of its reference and of the first one, as a text. Other variants do not count, so
  /// that its length does not grow with their number.
  const std::string& of_variant(std::size_t variant) const { return texts_[variant]; }

 private:
  std::vector<std::string> texts_;
};

/// Writes the row of a run that was made with these inputs. Throws OutputError.
void write_study_row(const std::string& path, const StudyRow& row, const std::string& inputs);

/// The row of the planned run in this file, or nothing if the file is not there, is not such a file, or
/// belongs to another run or to other inputs.
std::optional<StudyRow> read_study_row(const std::string& path, const PlannedRun& planned,
                                       const std::string& inputs);

}  // namespace tetraction
