// One load step: from an equilibrium to another one with a larger load factor.
#pragma once

#include <memory>

#include "tetraction/dynamics/problems/static_problem.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// A stepper whose time is the load factor (StaticProblem). A step minimises Π at the load factor of
/// its end, beginning at the positions of its start, and leads to a state without momentum. Under loads
/// that depend on positions it solves the equations of equilibrium, which are not those of a minimum.
class StaticStepper : public Stepper {
 public:
  /// How equilibria under loads that depend on positions are found if there is a root finder.
  enum class FollowerLoads {
    kSolve,          ///< by the root finder
    kMinimizeFirst,  ///< by repeated minimisations, and by the root finder where these find none
  };

  /// Potentials, loads and targets are those at `time`. `root_finder` is for loads that depend on positions;
  /// without one (null), minimisations are repeated until such loads fit the positions. Keeps a
  /// reference to `system`.
  static std::unique_ptr<StaticStepper> make(const MechanicalSystem& system,
                                             std::shared_ptr<Minimizer> minimizer, double time,
                                             std::shared_ptr<RootFinder> root_finder = nullptr,
                                             FollowerLoads follower_loads = FollowerLoads::kSolve);
  /// Lets the next steps minimise Π with constant loads, which are replaced until they fit the positions,
  /// although there is a root finder; or not any more. A minimiser finds stable equilibria only, also
  /// far away.
  virtual void set_minimizes(bool minimizes) = 0;
  /// Says whether a step that fails will be tried in parts (StaticProblem::set_divisible()).
  virtual void set_divisible(bool divisible) = 0;
  /// The problem of the last step.
  virtual const StaticProblem& problem() const = 0;

 protected:
  using Stepper::Stepper;
};

}  // namespace tetraction
