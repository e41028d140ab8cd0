// The runs in the directory of a study: those that are there already, and those that are made.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/results/result_folders.h"
#include "study_run_files.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// StudyRequests::seconds_per_step as the study in this directory left it (PlannedSteps), if that has this digest.
std::map<Integrator, double> times_of_choice(const std::string& directory,
                                             const std::string& digest);

/// Keeps row and track of each run in its folder, and takes over the runs of earlier studies that computed the same.
class StudyFolder {
 public:
  /// The runs of the plan do not count. Plan, mesh and digests, which are those of the variants of the plan, must live
  /// longer.
  StudyFolder(std::string directory, const StudyPlan& plan, const TetMesh& mesh,
              const RunDigests& digests);

  /// Sets the folders of the runs that write frames. By default there are none.
  void set_frames(const std::vector<std::string>& runs) { frames_ = {runs.begin(), runs.end()}; }
  bool has_frames(const std::string& run) const { return frames_.contains(run); }
  std::string path(const std::string& run) const { return directory_ + "/" + run; }

  /// What run_study() needs. It is valid as long as this object lives.
  StudyMemory memory();

  /// Makes the folder of a run that begins. The first run begins the study of the scene with this name. Throws
  /// OutputError.
  void begin_run(const std::string& run, const std::string& scene_name);

 private:
  std::string file(const PlannedRun& run, const char* name) const;
  std::shared_ptr<const MotionTrack> track(const PlannedRun& run);
  std::optional<StudyRow> kept(const PlannedRun& run);
  void keep(const PlannedRun& run, const StudyRow& row, const MotionTrack& track);

  std::string directory_;
  const StudyPlan& plan_;
  const TetMesh& mesh_;
  const RunDigests& digests_;
  std::set<std::string> frames_;
  std::optional<StudyJournal> journal_;
  std::map<std::string, std::shared_ptr<const MotionTrack>> read_;  // tracks by their folders
  std::uintmax_t read_bytes_ = 0;
};

}  // namespace tetraction
