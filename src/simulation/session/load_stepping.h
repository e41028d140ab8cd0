// The size of load steps.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tetraction/dynamics/steppers/static_stepper.h"
#include "tetraction/simulation/equilibrium.h"

namespace tetraction {

/// The stepper of load steps with the solver of the settings, which goes on to round-off. Throws
/// InputError.
std::unique_ptr<StaticStepper> make_static_stepper(const MechanicalSystem& system,
                                                   const SolverSettings& solver, double time);

/// Throws InputError if a rigid motion is free.
void refuse_free_motions(const MechanicalSystem& system, double time);

/// Chooses the increments of the load factor as find_equilibrium() says.
class LoadStepping {
 public:
  /// Keeps a reference to the stepper, which must live longer. Throws InputError unless the largest
  /// increment is above 0 and at most 1. `examines_stability`: whether equilibria under loads that depend on
  /// positions are examined for motions that grow.
  LoadStepping(StaticStepper& stepper, double largest_increment, bool examines_stability = true);

  /// One load step from `from` to `to`, whose times are load factors. If none is possible, the outcome
  /// says why. The report is the sum over all attempts.
  StepOutcome advance(const State& from, State& to);
  /// The increment that the next step tries, and those that were taken.
  double increment() const { return increment_; }
  const LoadPath& path() const { return path_; }
  /// The time that the examination of equilibria for motions that grow has taken, s.
  double examination_seconds() const { return examination_seconds_; }
  /// A message after a step with this outcome: why there was no equilibrium, which limit points
  /// the path has passed, or that round-off is large. Empty if there is nothing.
  std::string message(const StepOutcome& outcome) const;

 private:
  // A result whose stiffness was not positive definite everywhere on the way.
  struct Beyond {
    State state;
    StepOutcome outcome;
    Reactions reactions;
    bool found() const { return state.position.size() > 0; }
  };

  // Whether the equilibrium is known to be unstable, with what is known of the motion.
  std::optional<LossOfStability> instability(const State& at);
  // Whether the equilibrium is so much less stiff than the body at rest that a limit point must be near.
  bool is_nearly_singular(const State& at) const;
  // Looks for a stable equilibrium under loads that depend on positions by minimisation, where the path of
  // Newton's method ends or has become unstable.
  bool find_beyond(const State& from, State& to, double next, Beyond& beyond);
  void enter_limit_point(const LimitPoint& limit);
  StepOutcome accept(const StepOutcome& outcome, const State& to);

  StaticStepper& stepper_;
  double largest_increment_;
  double increment_;
  double rate_ = 0.0;  // at which a coordinate moved in the last step, m; 0: not known
  LoadPath path_;
  MinimizerReport sum_;  // of the attempts of a step
  int quick_ends_ = 0;   // attempts in a row that failed although they could be divided
  int searches_ = 0;     // for a stable equilibrium beyond the path of Newton's method
  double examination_seconds_ = 0.0;
};

/// A message if round-off kept the last load step from a good balance of forces; otherwise empty.
std::string round_off_text(const LoadPath& path);

/// A message about a limit point.
std::string limit_text(const LimitPoint& limit);
/// A message about an equilibrium that loads make unstable.
std::string loss_text(const LossOfStability& loss);

}  // namespace tetraction
