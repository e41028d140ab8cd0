// One load step: from an equilibrium to another one with a larger load factor.
#pragma once

#include <memory>

#include "tetraction/dynamics/static_problem.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {

/// A stepper whose time is the load factor (StaticProblem). A step minimises Π at the load factor of
/// its end, beginning at the positions of its start, and leads to a state without momentum.
class StaticStepper : public Stepper {
 public:
  /// Potentials, loads and targets are those at `time`. Keeps a reference to `system`.
  static std::unique_ptr<StaticStepper> make(const MechanicalSystem& system,
                                             std::shared_ptr<Minimizer> minimizer, double time);
  /// The problem of the last step.
  virtual const StaticProblem& problem() const = 0;

 protected:
  using Stepper::Stepper;
};

}  // namespace tetraction
