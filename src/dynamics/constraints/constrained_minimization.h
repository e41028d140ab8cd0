// The minimisation of an implicit step or of an equilibrium, with the multipliers of constraints.
#pragma once

#include <functional>
#include <memory>

#include "constraint_potential.h"
#include "dynamics/terms/followed_loads.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/dynamics/problems/potential_problem.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// Minimises the function of a PotentialProblem. If the constraints have equations, it finds
/// their multipliers together with the minimiser.
class ConstrainedMinimization {
 public:
  /// The equations hold at the configuration w(q) + `stretch` (w(x) − w(q)), which is that of the
  /// end of a step; an equilibrium has the stretch 1. Keeps a reference to `problem`. If there is a root
  /// finder and loads depend on positions, it solves the equations with these loads, and the problem
  /// takes them.
  ConstrainedMinimization(PotentialProblem& problem, std::shared_ptr<Minimizer> minimizer,
                          std::shared_ptr<RootFinder> root_finder, double stretch,
                          ConstraintDirection direction);

  /// Where minimisations begin and end: the displacement from the problem's origin.
  Vector& u() { return u_; }
  const Vector& u() const { return u_; }
  /// u() ← the minimiser, beginning at u(). `from` is the reference q, m. If there is none, the
  /// outcome says why and false is returned. The reports of all minimisations are added to that of
  /// the outcome.
  bool minimize(const Vector& from, StepOutcome& outcome);
  /// The same with the forces of constraints that the problem has.
  bool solve(StepOutcome& outcome);
  /// The solution u() and the forces of constraints of a problem that `solve` solves with the forces that the
  /// problem has. `linearize` is called before the minimiser solves linearised equations. With
  /// fewer than kRounds rounds, for which the caller has an alternative, nothing is tried a second time.
  bool solve_with_multipliers(const Vector& from, StepOutcome& outcome,
                              const std::function<bool()>& solve,
                              const std::function<void()>& linearize = {},
                              int most_rounds = kRounds);
  /// Adds the potential of the constraints' equations to the problem, with the multipliers of the last
  /// solution. To be called after the problem's begin() if values of its function are to contain it.
  void add_constraint_potential();
  /// r ← what is not in balance at u() (3 per vertex, N).
  EvaluationStatus residual(Vector& r) const;
  /// correction ← the displacement from u() to the solution of the linearised equations. Returns false if the matrix is
  /// not positive definite, or if loads depend on positions, if it is singular.
  bool newton_correction(Vector& correction);
  /// The generalised forces on the configuration at the last minimiser; empty without equations.
  const Vector& constraint_force() const { return constraint_force_; }
  /// Sets them, after another method has found them.
  void set_constraint_force(const Vector& force) { constraint_force_ = force; }
  /// Whether the solutions are those with the loads at their positions.
  bool follows_loads() const {
    return root_finder_ && !minimizes_ && problem_.has_following_forces();
  }
  /// Lets it minimise with constant loads although there is a root finder, or not any more.
  void set_minimizes(bool minimizes) { minimizes_ = minimizes; }
  /// Forgets them, so that the next minimisation does not begin with them.
  void forget() {
    constraint_force_.resize(0);
    force_before_.resize(0);
    multipliers_.resize(0);
    influence_.resize(0, 0);
    steps_without_rounds_ = 0;
  }

 private:
  static constexpr int kRounds = 60;

  bool is_solved(StepOutcome& outcome);
  bool is_minimum_on_constraints() const;
  bool solve_rounds(const Vector& from, StepOutcome& outcome, const std::function<bool()>& solve,
                    const std::function<void()>& linearize, int most_rounds, bool is_quick);
  bool solve_roughly(double roughness, const std::function<bool()>& solve, StepOutcome& outcome);
  bool find_influence(StepOutcome& outcome);
  bool solve_saddle_point(StepOutcome& outcome);
  bool take_saddle_point();
  bool find_correction(const Vector& g);
  bool solve_linear(const Matrix& forces, Matrix& displacements);
  void apply_constraint_force(const Vector& u);

  const MechanicalSystem& system_;
  PotentialProblem& problem_;
  std::shared_ptr<Minimizer> minimizer_;
  std::shared_ptr<RootFinder> root_finder_;
  FollowedLoads equations_;
  bool minimizes_ = false;
  double stretch_;
  ConstraintDirection direction_;
  Vector u_;
  Vector constraint_force_;
  Vector force_before_;           // the same of the minimisation before it; empty: not known
  int steps_without_rounds_ = 0;  // of the direction kEnd, before rounds are tried again
  Matrix influence_;  // of forces on the configuration on free coordinates, m/N; empty: not known
  ConstraintPotential potential_;
  Vector multipliers_;  // of potential_; empty: not known
  // Results of find_correction(), for u_ and for the multipliers.
  Vector correction_;
  Vector multiplier_correction_;
  Vector gradient_;  // work space
};

}  // namespace tetraction
