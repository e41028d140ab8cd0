// The result of one run of a study in a file of its own, so that other studies of the same scene can take it over.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The name of the file in the folder of a run.
inline constexpr const char* kStudyRowFile = "study_row.json";

/// Numbers that tell what the runs of a study compute. Runs with the same one have the same results, whatever study
/// they belong to.
class RunDigests {
 public:
  RunDigests(const StudyPlan& plan, const TetMesh& mesh);

  RunDigests(std::string build, std::vector<std::string> scenes, std::vector<std::string> meshes)
      : build_(std::move(build)), scenes_(std::move(scenes)), meshes_(std::move(meshes)) {}

  /// Made from the build of the program, the scene without [output], its mesh and the files that it reads, and
  /// from integrator, step and solver of the run.
  std::string of(const PlannedRun& run) const;

  const std::string& build() const { return build_; }
  /// Of each variant, with the files that the scene reads, but without its mesh.
  const std::vector<std::string>& scenes() const { return scenes_; }
  const std::vector<std::string>& meshes() const { return meshes_; }

 private:
  std::string build_;
  std::vector<std::string> scenes_;
  std::vector<std::string> meshes_;
};

/// Writes the row of a run with this digest. Throws OutputError.
void write_study_row(const std::string& path, const StudyRow& row, const std::string& digest);

/// The row of the planned run in this file, or nothing if the file is not there, is not such a file, or
/// has another digest.
std::optional<StudyRow> read_study_row(const std::string& path, const PlannedRun& planned,
                                       const std::string& digest);

}  // namespace tetraction
