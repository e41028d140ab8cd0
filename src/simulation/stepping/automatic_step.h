// time.step = "auto": the step is half of the stability limit and follows it while the body moves.
#pragma once

#include "tetraction/simulation/run_progress.h"

namespace tetraction {

/// Decides when the limit is estimated again and which step follows from it. What it remembers is
/// plain data of the run, to which it refers: a copy of them, together with a copy of the state, is
/// enough to continue the run in the same way.
///
/// The step is reduced at once when it is more than 1.1 times its intended size. Because of this
/// tolerance it stays the same while a body merely swings. It grows by 2 % with an estimate (by 10
/// % if it is less than half of its intended size), and only after the limit has been well above it
/// for eight estimates in a row.
///
/// The usual interval between estimates is so long that they cost about 2.5 % of the steps. An
/// estimate comes sooner in three cases: the limit has been changing so fast that it could fall
/// below the step, the run has just begun, so that this is not known, or the energy error begins to
/// grow.
class AutomaticStep {
 public:
  /// Ratio of the intended step to the limit.
  static constexpr double kShare = 0.5;

  /// Keeps a reference to `memory`.
  explicit AutomaticStep(AutomaticStepMemory& memory) : memory_(memory) {}
  /// Starts with a limit that was computed without earlier modes before step number `step` + 1.
  void start(double critical_step, CriticalModes modes, Index step);

  /// Whether an estimate is due before the step after `step`.
  bool is_due(Index step) const { return step >= memory_.next; }
  /// The modes with which the next estimate begins, and which it replaces by those that it found.
  CriticalModes& modes() { return memory_.modes; }
  /// Records an estimate that cost as much as `cost` steps. Returns the step to use from now on
  /// instead of `time_step`.
  double enter(double critical_step, double cost, Index step, double time_step);

  /// Records by how much the energy error changed in step number `step`, and the energy that has
  /// entered so far, J. An instability begins with a change far above all recent ones. In that case
  /// an estimate becomes due.
  void watch(double change, double scale, Index step);

  /// Records the elastic energy after a step, J. A body that is compressed stiffens, and its limit
  /// changes with its energy. An estimate becomes due when the energy has changed so much since the
  /// last one that, judging by the relation of both so far, the limit should have changed by a
  /// twentieth.
  void watch_elastic(double energy, Index step);

  /// The limit at the last estimate, s.
  double critical_step() const { return memory_.critical_step; }
  /// The smallest limit of the last estimates, s.
  double least_recent() const;

 private:
  double changed_step(double time_step);

  AutomaticStepMemory& memory_;
};

}  // namespace tetraction
