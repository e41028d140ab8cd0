// time.step = "auto": half of the stability limit, followed while the body moves.
#pragma once

#include <array>

#include "tetraction/dynamics/stability.h"

namespace tetraction {

/// Says when the limit is to be estimated anew and what step follows from it. Plain data: a copy is what
/// a state needs to go on as it did.
///
/// The step is made smaller at once when it is more than 1.1 times what it should be, so that it stays
/// the same while a body merely swings. It grows by 2 % an estimate (by 10 % where it is less than half of
/// what it should be), and only after the limit has been well above it for eight estimates in a row.
///
/// Estimates come so seldom that they cost about 2.5 % of the steps; sooner where the limit has been
/// changing so fast that it could fall below the step, in the first steps, when this is not known, and
/// when the energy error begins to grow.
class AutomaticStep {
 public:
  /// The share of the limit that the step is.
  static constexpr double kShare = 0.5;

  AutomaticStep() = default;
  /// Begins at a limit that was worked out from scratch before step number `step` + 1.
  AutomaticStep(double critical_step, CriticalModes modes, Index step);

  /// Whether the limit is to be estimated before the step after `step`.
  bool is_due(Index step) const { return step >= next_; }
  /// What the next estimate begins with and leaves behind.
  CriticalModes& modes() { return modes_; }
  const CriticalModes& modes() const { return modes_; }
  /// Enters an estimate that cost as much as `cost` steps. Returns the step to take from now on instead of
  /// `time_step`.
  double enter(double critical_step, double cost, Index step, double time_step);

  /// Enters by how much the energy error changed in the step that ended as number `step`, and the energy
  /// that entered so far, J. A change far above all those lately is how an instability begins: then an
  /// estimate is due.
  void watch(double change, double scale, Index step);

  /// Enters the elastic energy after a step, J. An estimate is due where it has changed so much since the
  /// last one that the limit should have changed by a twentieth, as it went with the energy before: a body
  /// that is pressed together stiffens with it.
  void watch_elastic(double energy, Index step);

  /// The limit at the last estimate, s.
  double critical_step() const { return critical_step_; }

 private:
  static constexpr std::size_t kRemembered = 8;

  double changed_step(double time_step);

  CriticalModes modes_;
  double critical_step_ = 0.0;
  double rate_ = 0.0;  // |d ln h_crit| a step
  Index last_ = 0;
  Index next_ = 0;
  Index interval_ = 0;
  std::array<double, kRemembered> recent_{};  // limits, the oldest replaced first
  std::size_t known_ = 0;                     // how many since the beginning
  double largest_change_ = 0.0;               // of the energy error in a step lately, J
  bool grows_ = false;
  double elastic_energy_ = 0.0;              // after the last step, J
  double elastic_energy_at_estimate_ = 0.0;  // J
  double sensitivity_ = 0.0;                 // |d ln h_crit / d ln W| between the last estimates
};

}  // namespace tetraction
