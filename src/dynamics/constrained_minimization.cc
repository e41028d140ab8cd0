#include "constrained_minimization.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "solve_to_round_off.h"
#include "tetraction/dynamics/whole_body.h"

namespace tetraction {
ConstrainedMinimization::ConstrainedMinimization(PotentialProblem& problem,
                                                 std::shared_ptr<Minimizer> minimizer,
                                                 std::shared_ptr<RootFinder> root_finder,
                                                 double stretch, ConstraintDirection direction)
    : system_(problem.system()),
      problem_(problem),
      minimizer_(std::move(minimizer)),
      root_finder_(std::move(root_finder)),
      equations_(problem),
      stretch_(stretch),
      direction_(direction) {}

bool ConstrainedMinimization::minimize(const Vector& from, StepOutcome& outcome) {
  return problem_.constraints().has_equations() ? solve_with_multipliers(from, outcome)
                                                : solve(outcome);
}

// u_ ← the minimiser, beginning at u_. If Φ contains an estimate of the strain rate, the estimate
// is replaced by the strain rate of the minimiser until both agree.
bool ConstrainedMinimization::solve(StepOutcome& outcome) {
  constexpr int kEstimates = 40;
  double before = std::numeric_limits<double>::infinity();
  problem_.set_rate_estimate(u_);
  if (whole_freedom_count(system_) == 0) {  // x is where everything is prescribed to be
    outcome.minimizer.termination = Termination::kConverged;
    outcome.minimizer.message = "nothing to solve for: every vertex is held";
    return true;
  }
  const bool follows = follows_loads();
  problem_.set_with_load_stiffness(follows);
  for (int i = 0; i < kEstimates; ++i) {
    const MinimizerReport report = solve_to_round_off(problem_, u_, outcome.minimizer, [&] {
      return follows ? root_finder_->find_root(equations_, u_) : minimizer_->minimize(problem_, u_);
    });
    if (follows) problem_.take_loads(u_);
    if (!report.converged()) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = report.message;
      return false;
    }
    if (!problem_.needs_rate_estimate()) return true;
    problem_.set_rate_estimate(u_);
    double phi = 0.0;
    if (!problem_.value_and_full_gradient(u_, phi, gradient_).ok()) break;
    const double residual = system_.restricted_norm(gradient_);
    outcome.minimizer.residual = residual;
    if (residual <= std::max(report.residual, report.residual_limit)) return true;
    // If the residual does not fall any more, it is round-off.
    if (i > 2 && residual > 0.5 * before && residual <= kRoundOffMargin * problem_.round_off(u_)) {
      return true;
    }
    before = residual;
  }
  outcome.status = StepStatus::kNotConverged;
  outcome.message = "the strain rate of the viscosity does not settle";
  outcome.obstacle = StepObstacle::kViscosity;
  return false;
}

EvaluationStatus ConstrainedMinimization::residual(Vector& r) const {
  return follows_loads() ? equations_.residual(u_, r) : problem_.residual(u_, r);
}

bool ConstrainedMinimization::newton_correction(Vector& correction) {
  if (follows_loads()) return root_finder_->newton_correction(equations_, u_, correction);
  if (!problem_.residual(u_, gradient_).ok()) return false;
  const FreeCoordinates& coordinates = system_.coordinates();
  Matrix solution;
  if (!minimizer_->solve_linearized(problem_, u_, coordinates.restrict(gradient_), solution)) {
    return false;
  }
  correction = -coordinates.extend(solution.col(0));
  return true;
}

// Newton's method for positions and multipliers together. Each round moves both to the solution of
// the problem linearised at x. If that does not lower the residual, Φ is minimised with constant
// constraint forces before the next round.
bool ConstrainedMinimization::solve_with_multipliers(const Vector& from, StepOutcome& outcome) {
  constexpr int kRounds = 40;
  const Constraints& constraints = problem_.constraints();
  const Index size = constraints.configuration_size();
  const Vector start = constraints.configuration(from);
  Vector u = constraint_force_.size() > 0 ? constraint_force_ : Vector::Zero(size);
  Vector multipliers;
  double last_residual = std::numeric_limits<double>::infinity();
  bool minimize = true;
  for (int round = 0; round < kRounds; ++round) {
    apply_constraint_force(u);
    Matrix right(system_.coordinates().count(), size + 1);
    right.leftCols(size) = constraints.selector();
    right.col(size).setZero();
    double phi = 0.0;
    Vector gradient;
    if (round > 0) {
      minimize = true;
      problem_.set_rate_estimate(u_);
      if (problem_.value_and_gradient(u_, phi, gradient).ok()) {
        const double residual = gradient.norm();
        outcome.minimizer.residual = residual;
        if (residual <= outcome.minimizer.residual_limit) {
          constraint_force_ = u;
          return true;
        }
        minimize = !(residual < 0.5 * last_residual);
        last_residual = residual;
        right.col(size) = gradient;
      }
    }
    if (minimize) {
      if (!solve(outcome)) return false;
      right.col(size).setZero();
      last_residual = std::numeric_limits<double>::infinity();
    } else {
      ++outcome.minimizer.iterations;
    }
    // Of u on the free coordinates at x; last column: Newton's step.
    Matrix influence(0, size + 1);
    const bool movable = right.rows() > 0;
    if (movable) ++outcome.minimizer.factorizations;
    if (movable && !minimizer_->solve_linearized(problem_, u_, right, influence)) {
      if (!minimize) {
        last_residual = 0.0;  // minimise from here
        continue;
      }
      outcome.status = StepStatus::kNotConverged;
      outcome.message = "the stiffness at the minimum is not positive definite";
      return false;
    }
    u_ -= system_.coordinates().extend(influence.col(size));
    const Matrix response = constraints.selector().transpose() * influence.leftCols(size);
    const Vector way = constraints.configuration((problem_.origin() - from) + u_);
    const Vector free_end = start + stretch_ * (way - response * u);
    const MultiplierSolution solution = solve_multipliers(
        constraints, free_end, stretch_ * response, start, direction_, multipliers);
    if (!solution.ok && !minimize) {
      u_ += system_.coordinates().extend(influence.col(size));
      last_residual = 0.0;  // minimise from here
      multipliers.resize(0);
      continue;
    }
    if (!solution.ok) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = cannot_be_met(constraints, solution.worst);
      outcome.obstacle = StepObstacle::kConstraints;
      return false;
    }
    multipliers = solution.multipliers;
    u_ += system_.coordinates().extend(influence.leftCols(size) * (solution.forces - u));
    u = solution.forces;
  }
  outcome.status = StepStatus::kNotConverged;
  outcome.message = fmt::format("the multipliers did not settle in {} rounds", kRounds);
  outcome.obstacle = StepObstacle::kConstraints;
  return false;
}

void ConstrainedMinimization::apply_constraint_force(const Vector& u) {
  problem_.set_constraint_force(problem_.constraints().vertex_forces(u));
}

}  // namespace tetraction
