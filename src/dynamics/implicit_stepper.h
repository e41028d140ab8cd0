// The common part of the implicit time-stepping rules. A step is one minimisation of the
// incremental potential (step_problem.h), or a few if multipliers must be found, too.
#pragma once

#include <memory>

#include "constrained_minimization.h"
#include "first_guess.h"
#include "tetraction/dynamics/step_problem.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {

/// An implicit step takes its forces at x = q_k + αh v, which minimises the incremental potential
/// Φ. A rule says what α is, where the step ends, and what the momenta are there.
class ImplicitStepper : public Stepper {
 public:
  void reset() override;
  StepOutcome advance(const State& from, State& to, double h, double end_time) override;

 protected:
  /// `direction` tells whether the impulses of multipliers have their direction from q_k or from
  /// the end of the step.
  ImplicitStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer,
                  double alpha, ConstraintDirection direction);

  /// to.position ← q_{k+1}. to.velocity is already v.
  virtual void set_end_position(const State& from, State& to, double h) = 0;
  /// to.momentum ← p_{k+1}. Also enters the reactions of constraints. `start` is p_k after the
  /// impulses of the multipliers, 3 per vertex.
  virtual void set_end_momentum(const State& from, State& to, const Vector& start, double h,
                                StepOutcome& outcome) = 0;
  /// The lever arm of the minimiser's residual at a vertex, m
  /// (StepOutcome::residual_angular_impulse).
  virtual Vector3 residual_arm(const State& from, Index v) const = 0;

  // The data of the step in progress that the rules need.
  const StepProblem& problem() const { return problem_; }
  Vector x_;                 // where forces are taken
  Vector impulse_;           // of the multipliers, per vertex
  Vector constraint_force_;  // on the configuration, of the last step
  Vector outer_;             // the forces at x_ that change the body's momentum; work space then
  Vector force_;             // all forces at x_
  Vector carried_;           // M v
  Vector work_;

 private:
  bool find(const State& from, double end_time, StepOutcome& outcome);
  bool lead_along(const State& from, double end_time, StepOutcome& outcome);
  bool settle_loads(const State& from, double h, double end_time, StepOutcome& outcome);
  bool take_momenta(const State& from, State& to, double h, StepOutcome& outcome);
  void gather_forces(const TimeSpan& step, const Vector& velocity, const Vector& gradient);

  double alpha_;
  StepProblem problem_;
  ConstrainedMinimization solve_;
  FirstGuess guess_;
  // These are members in order to avoid allocations.
  Vector trial_;
  Vector load_;  // empty: none
  Vector spring_force_;
  bool constraining_ = false;  // a term stands for a constraint
  Vector damping_;
  Vector start_;
};

}  // namespace tetraction
