// A study from what it is asked for to its result, for the command and for Python.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/results/directory_lock.h"
#include "io/scene/scene_variants.h"
#include "study_folder.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// What a study is asked for, as the options of `tetraction study` and the arguments of Python's study() have it.
struct StudyOptions {
  std::vector<std::string> integrators;
  std::vector<std::string> rules;
  std::vector<std::string> steps;
  std::vector<std::string> vary;
  std::vector<std::string> also_solvers;
  std::string budget = "1min";
  std::string target;
  std::string error;
  std::string reference = "run";
  std::string reference_integrator;
  std::optional<double> reference_step;
  std::string part;  ///< "2/3"
  int repeats = 2;
  int jobs = 1;
  bool mesh_check = false;
  bool fresh = false;  ///< whether an earlier study in the directory is deleted
  bool plan = false;   ///< whether nothing is written, and no runs are made but trials
};

/// What a study works with.
struct StudyInputs {
  StudyOptions options;
  StudyRequests requests;
  StudySettings settings;
  std::size_t part = 0;  ///< from 0
  std::size_t parts = 1;
  Scene scene;  ///< the first variant
  std::shared_ptr<const TetMesh> mesh{};
  std::vector<std::string> warnings{};  ///< of materials, each once; StudyMaker fills them in
  std::string name{};                   ///< of the scene
  std::string directory{};              ///< of the results; empty: everything stays in memory
  bool keeps_runs = true;  ///< whether scene and mesh tell what the runs of a study compute
};

/// Reads the options and the scene; all but the last four members. Throws InputError for options that are malformed or
/// exclude each other, and what `read` throws.
StudyInputs read_study_inputs(const StudyOptions& options, const ReadScene& read,
                              const std::vector<std::string>& overrides);

/// Checks that the study may be made in its directory, before its inputs are read, and reads the meshes of the variants.
void read_study_mesh(StudyInputs& inputs, const ReadMesh& read);

/// What a program does while its study is made. Without functions it does nothing.
struct StudyHooks {
  StudyProgress progress{};
  std::function<void(const StudyRow&)> made{};  ///< called after each run that was not stopped
  /// Adds observers of a run.
  std::function<void(std::vector<std::unique_ptr<Observer>>&)> observe{};
  std::function<bool()> is_stopped{};  ///< whether the study is to end, as its observers end a run
  std::function<int()> stop_code{};    ///< RunRecorder::set_stop_code()
  std::function<void(const std::string&)> tell{};  ///< gets notes for the user
  std::function<void(const std::string&)>
      warn{};  ///< gets warnings about the materials, when the steps are known
};

/// A run of a plan.
struct PlannedTime {
  PlannedRun run;
  bool is_kept = false;  ///< whether it was made before
  Index steps = 0;
  double seconds = 0.0;  ///< estimated; NaN: not known
};

/// The number of steps of a run. Round-off makes no further one.
Index step_count(const StudyPlan& plan, const PlannedRun& run);

class StudyMaker {
 public:
  /// Throws InputError for what can be known to be wrong before the first run.
  StudyMaker(StudyInputs inputs, StudyHooks hooks);

  /// Chooses the steps and plans the runs. Returns false if it was stopped: there is no plan then. Throws InputError
  /// for what does not fit.
  bool choose();
  bool is_planned() const { return chosen_.has_value(); }

  /// The plan without runs, and with them.
  const StudyPlan& frame() const { return frame_; }
  const StudyPlan& plan() const { return plan_; }
  const StepChoice& choice() const { return chosen_->choice; }
  /// Whether there is an earlier study in the directory, whose runs are taken over.
  bool goes_on() const { return goes_on_; }
  /// The runs that this part of the study makes or keeps, with their times.
  std::vector<PlannedTime> planned_times();
  /// The run on the finer mesh, if one was asked for: that with the shortest step at most.
  std::optional<PlannedTime> planned_mesh_check();

  /// Makes the runs of the plan. `frames` are the folders of those that write frames.
  StudyResult make(const std::vector<std::string>& frames);

  StudyProvenance provenance(const std::string& command) const;
  /// The motion of a run that was made or kept; null if it is not known.
  std::shared_ptr<const MotionTrack> track(const PlannedRun& run);
  /// The plots of the earlier study in the directory.
  const std::vector<std::string>& old_plots() const { return old_plots_; }

 private:
  bool is_stopped() const { return hooks_.is_stopped && hooks_.is_stopped(); }
  void tell(const std::string& note) const;
  void begin();
  StudyMemory memory(StudyFolder* folder);
  ObserverFactory observers(StudyFolder* folder);
  TrackedRun make_one(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh,
                      StudyFolder* folder);
  std::shared_ptr<const TetMesh> fine_mesh() const;
  MeshCheck check_mesh(const StudyResult& result);
  void tell_of_kept_runs(const StudyResult& result) const;

  const StudyInputs inputs_;
  const StudyHooks hooks_;
  const StudyPlan frame_;  // without runs
  const RunDigests digests_;
  const bool goes_on_;
  const std::vector<std::string> old_plots_;
  std::unique_ptr<StudyFolder> folder_{};  // none: in memory
  const StudyMemory in_memory_ = memory_of_runs();
  std::optional<ChosenStudy> chosen_{};
  StudyPlan plan_{};
  std::optional<StudyPlan> finer_{};  // with a mesh check
  std::optional<DirectoryLock> lock_{};
  std::set<std::string> made_{};  // folders
};

}  // namespace tetraction
