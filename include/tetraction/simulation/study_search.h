// Which steps a study chooses itself: ladders of steps, the largest step that meets a target, the largest stable step.
//
// All steps are end/n with whole n. The searches make runs by a function of the caller, so that they know
// nothing of scenes and references.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// What a run told of a rule with n steps.
struct Trial {
  double error = std::numeric_limits<double>::quiet_NaN();  ///< relative; NaN: not known
  double seconds = 0.0;                                     ///< that it took
  bool failed = false;                                      ///< whether it did not reach the end
};

/// Makes the run of a rule (by its number) with n steps.
using MeasureRun = std::function<Trial(std::size_t rule, Index n)>;

/// The time for what the program chooses itself. Steps that were asked for do not count.
class StudyBudget {
 public:
  explicit StudyBudget(double seconds) : total_(seconds) {}

  bool allows(double seconds) const { return spent_ + seconds <= total_; }
  void spend(double seconds) { spent_ += seconds; }
  double total() const { return total_; }
  double spent() const { return spent_; }

 private:
  double total_;
  double spent_ = 0.0;
};

/// A rule whose steps are searched.
struct SearchedRule {
  std::string name;
  int order = 2;
  Index first = 10;  ///< n of the first run
  Index fewest = 1;  ///< least n that is tried; of an explicit rule end/h_crit, rounded up
  double seconds_per_step = 0.0;  ///< 0: not known before the first run
};

/// A reference that the program chooses.
struct ChosenReference {
  std::size_t rule = 0;
  Index n = 0;  ///< 0: no run reached the end
  /// Estimated from the run with half as many steps: its difference over 2^p − 1 with the order p.
  double error = std::numeric_limits<double>::quiet_NaN();
  int runs = 0;
};

/// Doubles or multiplies the number of steps of a rule until its error is at most `goal`, or the next run
/// would take more than `share` of the budget. The last run and that with half as many steps are always there. The
/// rule is the first one whose run with SearchedRule::first steps, as far as its time is known, takes
/// less than a quarter of the share; else the last one. `measure` returns as the error the relative difference from the
/// run of the rule with n/2 steps, or NaN if there was none.
ChosenReference find_reference(const std::vector<SearchedRule>& rules, double goal, double share,
                               StudyBudget& budget, const MeasureRun& measure);

/// A step of a ladder.
struct Rung {
  Index n = 0;
  double error =
      std::numeric_limits<double>::quiet_NaN();  ///< measured, or expected from the order
  double seconds = 0.0;                          ///< the same
  bool is_made = false;                          ///< whether it was a trial
};

/// The steps of a rule that bracket the errors of interest.
struct Ladder {
  std::vector<Rung> rungs;  ///< from the largest step to the smallest
  int trials = 0;           ///< number of runs that were made to find it
  /// Whether the smallest step has, or is expected to have, the error LadderSettings::fine.
  bool is_resolved = false;
  std::string remark{};  ///< why not, as a sentence; empty if it is resolved

  /// What the runs that are still to be made take, s.
  double seconds_left() const;
};

struct LadderSettings {
  double coarse = 0.1;   ///< error of the largest step, where the rule is stable there
  double fine = 1e-3;    ///< error of the smallest step
  double share = 0.03;   ///< of the budget that one trial may take
  int most_trials = 12;  ///< of a rule
};

/// A ladder for each rule, of n from the series 1, 2, 5, 10, ….
///
/// Trials go from SearchedRule::first towards larger steps until the error is `coarse`, and towards smaller
/// ones until it is `fine` or the next trial would not be cheap any more. The cheapest trial of all
/// rules comes first. The rest of a ladder follows from the order. If not all of it fits into the
/// budget, the most expensive steps are left out and the rule is not resolved. At least two rules
/// (if there are two that did not fail) keep two steps each, whatever the budget is.
std::vector<Ladder> find_ladders(const std::vector<SearchedRule>& rules,
                                 const LadderSettings& settings, StudyBudget& budget,
                                 const MeasureRun& measure);

enum class TargetOutcome {
  kMet,        ///< with the largest step that was found
  kStability,  ///< the target is met at the largest step at which the rule is stable
  kNotMet,     ///< not within the largest number of runs
  kNoBudget,   ///< the next run would take more than the budget has left
  kNoError     ///< the runs cannot be compared with the reference
};

struct TargetStep {
  TargetOutcome outcome = TargetOutcome::kNotMet;
  Index n = 0;    ///< smallest that was found to meet the target; 0: none
  Trial trial{};  ///< that run; without one the run with the smallest error
  std::vector<std::pair<Index, Trial>> runs{};  ///< in the order in which they were made
  /// Whether larger steps had larger errors. If not, still larger steps may meet the target as well.
  bool is_monotone = true;
};

/// The largest step end/n of a rule whose error is at most `target`, by secants of the logarithms of error
/// and n, at most `most_runs` runs. It ends when the secant finds no n that is smaller by more than half a
/// per cent. Runs that fail or whose error is unknown count as too coarse.
TargetStep find_target_step(const SearchedRule& rule, std::size_t index, double target,
                            StudyBudget& budget, const MeasureRun& measure, int most_runs = 8);

/// The largest stable step of a rule, between two numbers of steps.
struct StableStep {
  Index stable = 0;    ///< least n of the runs that reached the end; 0: none
  Index unstable = 0;  ///< largest n of those that failed; 0: none
  int runs = 0;
};

/// Bisection from n = `first` until stable ≤ (1 + accuracy) unstable, or the budget is spent.
StableStep find_stable_step(Index first, double accuracy, StudyBudget& budget,
                            const std::function<Trial(Index n)>& run);

}  // namespace tetraction
