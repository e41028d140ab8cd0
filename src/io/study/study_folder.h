// The runs in the directory of a study: those that are there already, and those that are made.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/results/result_folders.h"
#include "study_row_file.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// StudyRequests::seconds_per_step as the study in this directory left it (PlannedSteps), if that has this digest.
std::map<Integrator, double> times_of_choice(const std::string& directory,
                                             const std::string& digest);

/// Keeps row and track of each run in its folder, and takes over the runs of earlier studies that computed the same.
class StudyFolder {
 public:
  /// `frames` are the folders of the runs that write frames. Plan, mesh and digests, which are those of the variants of
  /// the plan, must live longer.
  StudyFolder(std::string directory, const StudyPlan& plan, const TetMesh& mesh,
              const RunDigests& digests, const std::vector<std::string>& frames);

  bool has_frames(const std::string& run) const { return frames_.contains(run); }
  std::string path(const std::string& run) const { return directory_ + "/" + run; }

  /// What run_study() needs. Runs that were made before are taken over if `keeps`.
  StudyMemory memory(bool keeps);

  /// Makes the folder of a run that begins. The first run begins the study of the scene with this name. Throws
  /// OutputError.
  void begin_run(const std::string& run, const std::string& scene_name);

 private:
  std::string file(const PlannedRun& run, const char* name) const;
  std::shared_ptr<const MotionTrack> track(const PlannedRun& run) const;
  std::optional<StudyRow> kept(const PlannedRun& run) const;
  void keep(const PlannedRun& run, const StudyRow& row, const MotionTrack& track);

  std::string directory_;
  const StudyPlan& plan_;
  const TetMesh& mesh_;
  const RunDigests& digests_;
  std::set<std::string> frames_;
  std::optional<StudyJournal> journal_;
};

/// Makes the run on the finer mesh (mesh_check_plan()) in its folder, or takes it from there if it `keeps` runs. `runs`
/// is the memory of the study, whose result is known.
MeshCheck check_mesh(const StudyPlan& finer, const StudyResult& result, const StudyMemory& runs,
                     StudyFolder& folder, bool keeps, const ObserverFactory& observers,
                     const StudyProgress& progress);

}  // namespace tetraction
