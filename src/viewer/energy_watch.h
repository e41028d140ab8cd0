// Watches the energy error of a run that a person looks at.
#pragma once

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Tells when the energy error has grown to more than a hundredth of the energy that entered
/// (Balance::energy_scale()) and to more than a step changes the kinetic energy, and stays there. The losses of `backward-euler` do not count, because
/// they are a property of that rule.
class EnergyWatch {
 public:
  /// From now on the present error counts as none.
  void restart(const Session& session);
  /// The user has seen the error and goes on: the next one must be twice as large.
  void allow(const Session& session);
  /// Must be called after each step. Returns whether the user should know.
  bool exceeded(const Session& session);
  double error() const { return error_; }      ///< since the restart, J
  double entered() const { return entered_; }  ///< J

 private:
  double start_ = 0.0;
  double error_ = 0.0;
  double entered_ = 0.0;
  double limit_ = 0.0;
  double kinetic_ = 0.0;   // after the last step, J
  double exchange_ = 0.0;  // the largest change of the kinetic energy in one of the steps_, J
  int steps_ = 0;          // in a row with a larger error
};

}  // namespace tetraction::viewer
