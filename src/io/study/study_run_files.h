// The result and the motion of a run of a study in files of their own, so that other studies of the same scene can take
// it over.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The names of the files in the folder of a run.
inline constexpr const char* kStudyRowFile = "study_row.json";
inline constexpr const char* kStudyTrackFile = "study_track.bin";

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

/// The member `plan` of study.json, StudyProvenance::plan.
std::string study_plan_json(const StudyPlan& plan, const RunDigests& digests);

/// Writes the row of a run with this digest. Throws OutputError.
void write_study_row(const std::string& path, const StudyRow& row, const std::string& digest);

/// The row of a run of the plan in this file, or nothing if the file is not there, is not such a file, or belongs to
/// another run.
std::optional<StudyRow> read_study_row(const std::string& path, const StudyPlan& plan,
                                       const PlannedRun& run, const std::string& digest);

/// Writes the track of a run, from which its errors are computed. Throws OutputError.
void write_study_track(const std::string& path, const MotionTrack& track,
                       const std::string& digest);

/// The track in this file, or null if the file is not there, is damaged, or belongs to another run.
std::shared_ptr<const MotionTrack> read_study_track(const std::string& path,
                                                    const std::string& digest);

}  // namespace tetraction
