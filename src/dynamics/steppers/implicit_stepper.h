// The common part of the implicit time-stepping rules. A step is one minimisation of the
// incremental potential (step_problem.h), or a few if multipliers must be found, too.
#pragma once

#include <memory>

#include "dynamics/constraints/constrained_minimization.h"
#include "first_guess.h"
#include "tetraction/dynamics/problems/step_problem.h"
#include "tetraction/dynamics/steppers/stepper.h"

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
                  std::shared_ptr<RootFinder> root_finder, double alpha,
                  ConstraintDirection direction);
  /// The same with a problem of the rule's own.
  ImplicitStepper(std::unique_ptr<StepProblem> problem, std::shared_ptr<Minimizer> minimizer,
                  std::shared_ptr<RootFinder> root_finder, double alpha,
                  ConstraintDirection direction);

  /// Finds x, where Φ is least. solve_ has the result. If there is none, the outcome says why and false
  /// is returned.
  virtual bool solve_step(const State& from, double end_time, StepOutcome& outcome) {
    return find(from, end_time, outcome);
  }
  /// The same, beginning at the origin, after the loads changed a little.
  virtual bool solve_again(const State& from, StepOutcome& outcome) {
    return solve_.minimize(from.position, outcome);
  }
  /// outer_ ← the forces at x_ that change the body's momentum, force_ ← all forces at x_,
  /// spring_force_ ← those of terms that stand for constraints (constraining_ says whether there are
  /// any). Returns false if they are not defined; the outcome says why.
  virtual bool gather_forces(const State& from, const State& to, double h, StepOutcome& outcome);
  /// The work of the constraints, J. reaction_ must not contain the springs.
  virtual double work_of_constraints(const State& from, const State& to) {
    return constraint_work(from, to);
  }
  /// The work of moving obstacles without friction, J, where there are any. obstacle_forces_ has their forces.
  virtual double work_of_obstacles(const State& from, const State& to) const;
  /// Minimises Φ, from the best guess or, if prescribed vertices move far, through intermediate steps.
  bool find(const State& from, double end_time, StepOutcome& outcome);
  /// Adds the forces of drag, mass damping and other dissipative terms to `forces`.
  void add_damping(const State& from, const Vector& velocity, Vector& forces) const;

  /// Adds the forces of friction to outer_.
  void add_friction(const State& to);

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
  const StepProblem& problem() const { return *problem_; }
  StepProblem& own_problem() { return *problem_; }
  Vector x_;                 // where forces are taken
  Vector impulse_;           // of the multipliers, per vertex
  Vector constraint_force_;  // on the configuration, of the last step
  Vector outer_;             // the forces at x_ that change the body's momentum; work space then
  Vector force_;             // all forces at x_
  Vector carried_;           // M v
  Vector work_;
  Vector load_;  // empty: none
  Vector spring_force_;
  bool constraining_ = false;                   // a term stands for a constraint
  std::vector<ObstacleForce> obstacle_forces_;  // without friction

 private:
  std::unique_ptr<StepProblem> problem_;

 protected:
  ConstrainedMinimization solve_;
  FirstGuess guess_;

 private:
  // The step of the own part of the body, with the part's shares in the balance.
  StepOutcome advance_part(const State& from, State& to, double h, double end_time);
  bool lead_along(const State& from, double end_time, StepOutcome& outcome);
  void enter_friction(double h, const State& to, StepOutcome& outcome);
  bool converge_loads(const State& from, double h, double end_time, StepOutcome& outcome);
  bool take_momenta(const State& from, State& to, double h, StepOutcome& outcome);

  bool moving_;  // prescribed vertices move
  double alpha_;
  // These are members in order to avoid allocations.
  Vector trial_;
  Vector damping_;
  Vector start_;
};

/// The midpoint rule where a body may touch obstacles: contact has a discrete gradient over the step, so that no step
/// ends beyond an obstacle.
std::unique_ptr<Stepper> make_midpoint_contact_stepper(const MechanicalSystem& system,
                                                       std::shared_ptr<Minimizer> minimizer,
                                                       std::shared_ptr<RootFinder> root_finder);

}  // namespace tetraction
