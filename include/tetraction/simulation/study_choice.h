// The steps of a study that the program chooses: trial runs, reference, ladders, targets.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/simulation/motion_track.h"
#include "tetraction/simulation/run_progress.h"
#include "tetraction/simulation/study_search.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {

/// What a run leaves for the choice of steps.
struct TrackedRun {
  std::shared_ptr<const MotionTrack> track{};  ///< null if the run did not reach the end
  double seconds = 0.0;                        ///< of its steps
  bool is_stopped = false;                     ///< on request: nothing more is to be made
  RunStatus status = RunStatus::kRunning;
};

/// Makes a run, or takes one that was made before, with the seconds that it took then: the choice is the same again.
using MakeTrackedRun = std::function<TrackedRun(const StudyRule& rule, double step)>;

/// A rule for which steps may have to be chosen.
struct RuleQuestion {
  StudyRule rule{};
  ResolvedSteps asked{};
  double stable_step = 0.0;       ///< h_crit of an explicit rule, s
  double seconds_per_step = 0.0;  ///< 0: not known
  bool adapts = false;  ///< whether it chooses the size of its steps: no step of it is searched
};

struct StepQuestion {
  std::vector<RuleQuestion> rules;
  /// The rules that may make the reference, the preferred one first (find_reference()).
  std::vector<RuleQuestion> references;
  std::optional<double> reference_step{};  ///< s, if it was asked for; of the first of `references`
  double end = 0.0;                        ///< s
  double period = 0.0;                     ///< excited period, s; 0: there is none
  ErrorMeasure error{};
  std::optional<double> target{};  ///< if the largest steps with this error are searched
  LadderSettings ladder{};
};

/// The steps of one rule.
struct RuleChoice {
  std::vector<double>
      steps;  ///< s, ascending: those that were asked for and those that were chosen
  std::vector<double> trials;  ///< s, ascending: further runs that were made
  std::optional<TargetStep> target{};
  std::optional<StableStep> stable{};  ///< of an explicit rule, as far as the budget reaches
};

struct StepChoice {
  std::vector<RuleChoice> rules;  ///< as StepQuestion::rules
  Integrator reference = Integrator::kMidpoint;
  double reference_step = 0.0;  ///< s; 0: no run of the reference reached the end
  double reference_error = std::numeric_limits<double>::quiet_NaN();  ///< estimated
  double seconds = 0.0;              ///< what the chosen runs that are still to be made take
  std::vector<std::string> remarks;  ///< sentences for the user
  bool is_stopped = false;           ///< whether a run was stopped on request
};

/// The relative error of a run; NaN if it is not known. Both tracks are whole.
double relative_error(const MotionTrack& run, const MotionTrack& reference,
                      const ErrorMeasure& measure);

/// Makes the trial runs that a study needs to know its steps: first a reference, whose error is at
/// most a tenth of the target or of the smallest error of a ladder, with at most two fifths of the budget; then
/// for each rule with a ladder those of find_ladders(), or with a target those of find_target_step(). What the
/// chosen runs leave of the budget is for find_stable_step() of the explicit rules.
StepChoice choose_steps(const StepQuestion& question, StudyBudget& budget,
                        const MakeTrackedRun& make);

}  // namespace tetraction
