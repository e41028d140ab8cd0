// Step-size studies: the same motion with several integrators and several step sizes.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/simulation/motion_track.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/study_choice.h"
#include "tetraction/simulation/study_result.h"

namespace tetraction {

/// A variant of the scene.
struct StudyVariant {
  std::string name;
  Scene scene;
  std::shared_ptr<const TetMesh> mesh{};  ///< null: the mesh that the study is given
  /// What makes it differ from the others. Without values it has a reference of its own.
  std::vector<VariedValue> values{};
  std::string folder{};  ///< begins the names of the folders of its runs; empty: the variant's name
};

/// How the reference of a study is made.
enum class ReferenceKind {
  kRun,        ///< one run
  kRichardson  ///< the extrapolation of runs with three steps, see ReferenceExtrapolation
};
template <>
struct EnumNames<ReferenceKind> {
  static constexpr std::array names{"run", "richardson"};
  static constexpr const char* noun = "a kind of reference";
};

/// A further run with another solver, in addition to those of every integrator at every step.
struct SolverComparison {
  std::string solver;  ///< a value of SolverSettings::kind that differs from the scene's
  double step = 0.0;   ///< s
};

/// The steps of one rule, s, ascending.
struct RuleSteps {
  Integrator integrator = Integrator::kMidpoint;
  std::vector<double> steps;
  std::vector<double> trials{};  ///< of runs that were made to find these steps
  /// Keys of [solver] and [time] that make it a rule of its own, such as solver.tolerance.
  std::vector<VariedValue> settings{};

  StudyRule rule() const { return {integrator, settings}; }
};

/// The runs that a study compares.
struct StudySettings {
  /// Scenes to run instead of the given one. Each is run with every integrator at every step. It is
  /// compared with a reference of its own scene: another material, load or mesh has another exact
  /// motion. Variants whose `values` differ in keys of the solver only have the same one, and share
  /// the reference of the first of them. All must have the same end time.
  std::vector<StudyVariant> variants;
  std::vector<Integrator> integrators;  ///< empty: all four
  std::vector<double> steps;            ///< s; empty: run_study() chooses them (choose_study())
  std::vector<RuleSteps> rule_steps{};  ///< if there are any, instead of `integrators` and `steps`
  /// Step of the reference run. By default it is the finest step of the study.
  std::optional<double> reference_step;
  Integrator reference_integrator = Integrator::kMidpoint;
  ReferenceKind reference_kind = ReferenceKind::kRun;
  /// Each of them is a run of the (first) scene with the first implicit integrator of the study.
  std::vector<SolverComparison> solver_comparisons;
  /// Name of a probe of the scene whose error gives the observed orders, or with ErrorKind::kEnergy the
  /// column of history.csv with an energy. Empty: the error of the positions does.
  std::string error_probe{};
  /// What counts of that probe: its values over time, or only their peak or their frequency.
  ErrorKind error_kind = ErrorKind::kProbe;
  /// How often a run that was asked for is made again to see how much its times vary. The cheapest runs are
  /// repeated first, one after the other, as long as this takes at most repeat_seconds together.
  int repeats = 0;
  double repeat_seconds = 6.0;  ///< s, of processor time
};

/// One run of a study.
struct PlannedRun {
  std::size_t variant = 0;  ///< index in StudyPlan::variants
  Integrator integrator = Integrator::kMidpoint;
  double step = 0.0;                    ///< s
  std::string solver;                   ///< SolverSettings::kind; empty for explicit integrators
  bool compares_solver = false;         ///< one of StudySettings::solver_comparisons
  std::vector<VariedValue> settings{};  ///< RuleSteps::settings
  StudyRole role = StudyRole::kRun;
  std::string directory;     ///< directory of its results, relative to the study's
  bool is_left_out = false;  ///< another part of the study makes it

  StudyRule rule() const { return {integrator, settings}; }
};

/// A reference of a study.
struct PlannedReference {
  std::size_t variant = 0;  ///< the first one that is compared with it
  /// Indices in StudyPlan::runs: one run, or those that are extrapolated, with the steps 2h, h and h/2. The last one
  /// is the finest.
  std::vector<std::size_t> runs;
};

/// All runs of a study, known before the first one begins. They do not depend on each other.
struct StudyPlan {
  std::vector<StudyVariant> variants;  ///< at least one, whose name is empty if nothing is varied
  double stable_step = 0.0;  ///< h_crit of `explicit` at the initial state of the first variant, s
  double end = 0.0;          ///< s
  /// The rows of the result, sorted by variant, integrator, then step from the finest up. The comparisons
  /// of solvers follow the other runs of their integrator.
  ///
  /// The reference has an error of its own if another run of its rule has a larger step at which it can be
  /// stable. If none was asked for, there is one at twice the step of the reference, with the role kReference.
  std::vector<PlannedRun> runs;
  std::vector<PlannedReference> references;  ///< in the order of their variants
  std::vector<std::size_t> reference_of;     ///< for each variant the index in `references`
  /// For each reference whether it has the vertices and tetrahedra of the first one, so that the
  /// positions of the two can be compared.
  std::vector<bool> has_first_mesh;

  std::string error_probe{};                 ///< StudySettings::error_probe
  ErrorKind error_kind = ErrorKind::kProbe;  ///< StudySettings::error_kind
  std::vector<ProbeColumns> probes{};        ///< of the first variant
  int repeats = 0;                           ///< StudySettings::repeats
  double repeat_seconds = 0.0;               ///< StudySettings::repeat_seconds

  /// What the errors of error_probe are. Its name is empty without one.
  ErrorMeasure error_series() const { return {error_kind, error_probe}; }
  const PlannedRun& finest_run(const PlannedReference& reference) const {
    return runs[reference.runs.back()];
  }
};

/// Checks the settings and fills in everything of a plan but runs and references.
StudyPlan begin_plan(const Scene& scene, const TetMesh& mesh, const StudySettings& settings);

/// A run of a variant with this rule and step, as plan_study() plans it. Throws InputError for settings of the rule
/// that do not fit the scene.
PlannedRun planned_run(const StudyPlan& plan, std::size_t variant, const StudyRule& rule,
                       double step);

/// Checks the settings and plans the runs. Throws InputError for steps that are missing, not positive or longer
/// than the end time, variants that end at different times, an error probe that a variant does not
/// have, events that change [time], settings of rules that do not fit, and solvers that cannot be compared.
StudyPlan plan_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings);

/// Leaves all runs but each `parts`-th one to other parts of the study, of which this is number `part` from 0.
/// The runs of the references are shared out, too.
void leave_to_others(StudyPlan& plan, std::size_t part, std::size_t parts);

/// Makes the observers of one run, given its directory relative to the study's.
using ObserverFactory =
    std::function<std::vector<std::unique_ptr<Observer>>(const std::string& directory)>;
/// A function that is called before each run with its number from 0, the number of runs, and the
/// run.
using StudyProgress = std::function<void(std::size_t, std::size_t, const PlannedRun&)>;

/// Where the track of a run is taken from when runs are compared: null if it is not known.
using TrackSource = std::function<std::shared_ptr<const MotionTrack>(const PlannedRun&)>;

/// What a study takes over from an earlier one, and where it leaves its runs. Without functions everything is
/// in memory.
struct StudyMemory {
  /// The row of a run that was made before, as `made` got it, or nothing if it has to be made.
  std::function<std::optional<StudyRow>(const PlannedRun&)> kept{};
  /// Called after each run that was made and not stopped. The row has no errors yet.
  std::function<void(const PlannedRun&, const StudyRow&, const MotionTrack&)> made{};
  /// The tracks of runs that were kept or made. Without it those of all runs stay in memory.
  TrackSource track{};
  /// Called after the repeats of a run with its new row.
  std::function<void(const PlannedRun&, const StudyRow&)> repeated{};
  /// Whether repeats are to stop.
  std::function<bool()> is_stopped{};
};

/// Keeps rows and tracks in memory, as long as one of its copies lives.
StudyMemory memory_of_runs();

/// Makes the runs of the plan that `memory` does not keep, the references first, and compares all of them. A
/// run that blows up or fails is a result, not an error.
///
/// All final positions belong to the same time: if a step does not divide the end time, the last
/// step is shorter.
///
/// Up to `jobs` runs are made at the same time, each with thread_count() threads. The result does not depend
/// on that, nor on which runs were kept, but for times and dates.
/// The functions that are called for the runs are never called at the same time. The observers of
/// different runs are, and so are force terms and materials of a program that several variants share.
/// StudyRow::shares_machine says whether the runs had too few cores.
///
/// Then the cheap runs are repeated, as StudySettings::repeats says: those with the role kRun that reached the end
/// on this kind of processor, took less than half a second of processor time, and shared no cores. Repeats have no
/// observers. Those of a run that are stopped do not count, nor those that end at other positions than the run: a
/// remark says so.
StudyResult run_study(const StudyPlan& plan, const TetMesh& mesh,
                      const ObserverFactory& observers = {}, const StudyProgress& progress = {},
                      const StudyMemory& memory = {}, int jobs = 1);

/// Makes one run, or takes it from `memory`, for the choice of steps.
TrackedRun make_tracked_run(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh,
                            const ObserverFactory& observers, const StudyProgress& progress,
                            const StudyMemory& memory);

/// Settings of a study with steps for each rule, and how they were chosen.
struct ChosenStudy {
  StudySettings settings;
  StepChoice choice;
  std::optional<double> target{};  ///< for StudyResult, as the following ones
  std::vector<RuleFinding> findings{};
  std::optional<PlannedSteps> plan{};  ///< if steps were chosen

  /// Enters the choice in the result of the study.
  void add_to(StudyResult& result) const;
};

/// Resolves the steps that are asked for. If some are to be chosen, makes trial runs of the first variant with `make`,
/// within the budget. `frame` is begin_plan() of the settings, whose own integrators and steps do not
/// count. Throws InputError for steps that do not fit the scene.
ChosenStudy choose_study(const StudyPlan& frame, const TetMesh& mesh, StudySettings settings,
                         const StudyRequests& requests,
                         const std::function<TrackedRun(const PlannedRun&)>& make);

/// The time that a run takes, as its first steps tell, s. NaN if they fail.
double estimated_seconds(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh);

/// Plans a study and makes its runs. If the settings have no steps, it chooses a ladder for each rule, with
/// StudyRequests::budget. reference_integrator then counts unless it is the default. The trial runs are not made again.
/// If one of them is stopped, the result has no runs, and is_interrupted says so.
StudyResult run_study(const Scene& scene, const TetMesh& mesh, const StudySettings& settings,
                      const ObserverFactory& observers = {}, const StudyProgress& progress = {});

/// Computes the errors, orders and references of runs from their tracks. `rows` has an entry for each of
/// plan.runs, empty for runs that were not made.
///
/// The observed order p solves e(h₂)/e(h₁) = (h₂/h₁)^p. The errors of runs of the reference's own
/// integrator are differences from a run of the same family. For these the right-hand side is (h₂^p
/// − h_r^p)/(h₁^p − h_r^p), unless the reference is extrapolated. If the error of the reference
/// itself is not small compared with the others, there is no order.
StudyResult compare_runs(const StudyPlan& plan, const std::vector<std::optional<StudyRow>>& rows,
                         const TrackSource& tracks);

/// The mesh of the first variant, refined once. `plan` needs no runs. Throws InputError for a scene that is another
/// problem there, as one with a force on every vertex.
TetMesh mesh_of_mesh_check(const StudyPlan& plan, const TetMesh& mesh);

/// The runs that could be made on that mesh, with folders of their own. Throws InputError if there are none: explicit
/// rules need about half the step there.
StudyPlan mesh_check_plan(const StudyPlan& plan, std::shared_ptr<const TetMesh> fine);

/// The run of mesh_check_plan() with the largest step whose error in the study is at most 1 %, or else the one with
/// the smallest error. Null if none of them reached the end.
const PlannedRun* run_of_mesh_check(const StudyPlan& finer, const StudyResult& result);

/// The folder of the same run on the mesh of the study.
std::string coarse_run_of(const PlannedRun& run);

/// The relative difference of the same run on a mesh and on the finer one, at the end at the vertices of the
/// coarse mesh, or of the error probe. Both tracks are whole.
double mesh_difference(const StudyPlan& plan, const MotionTrack& coarse, const MotionTrack& fine);

/// The p of (h2^p − hr^p)/(h1^p − hr^p) = e2/e1 with h2 > h1 > hr ≥ 0, or NaN without one in
/// (0, 12).
double observed_order(double h1, double e1, double h2, double e2, double hr = 0.0);

}  // namespace tetraction
