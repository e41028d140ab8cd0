#include "constrained_minimization.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "dynamics/problems/solve_to_round_off.h"
#include "dynamics/steppers/common_outcome.h"
#include "tetraction/dynamics/body_sums.h"

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
      direction_(direction),
      potential_(problem.constraints()) {}

bool ConstrainedMinimization::minimize(const Vector& from, StepOutcome& outcome) {
  if (!problem_.constraints().has_equations()) return solve(outcome);
  const auto solve_in_rounds = [&](int most_rounds) {
    return solve_with_multipliers(
        from, outcome, [&] { return is_solved(outcome) || solve(outcome); }, {}, most_rounds);
  };
  if (direction_ != ConstraintDirection::kEnd) return solve_in_rounds(kRounds);
  if (!problem_.has_inertia()) return solve_saddle_point(outcome);
  // Where rounds settle soon, they take less time than the search for a saddle point. Where they do not, those of the
  // next steps will not either.
  constexpr int kFewRounds = 8;
  constexpr int kStepsWithoutRounds = 20;
  const Vector start = u_;
  const Vector force = constraint_force_;
  const auto is_hopeless = [&] {
    if (outcome.obstacle == StepObstacle::kViscosity) return true;
    u_ = start;
    constraint_force_ = force;
    problem_.set_constraint_potential(nullptr);
    forget_failure(outcome);
    return false;
  };
  if (steps_without_rounds_ > 0) {
    --steps_without_rounds_;
  } else {
    if (solve_in_rounds(kFewRounds) && is_minimum_on_constraints()) return true;
    if (is_hopeless()) return false;
    steps_without_rounds_ = kStepsWithoutRounds;
  }
  if (solve_saddle_point(outcome)) return true;
  // Round-off of the stiff constraints may hide the forces of soft elements. Constant forces have none.
  if (is_hopeless()) return false;
  return solve_in_rounds(kRounds);
}

// Whether the solution of the rounds is a minimum. With the Hessian H of the function, the response R = BᵀH⁻¹B and
// the curvature C = Σ λ_i ∂²g_i of the equations, H − BCBᵀ is positive definite if the norm of RC is below one,
// because H is.
bool ConstrainedMinimization::is_minimum_on_constraints() const {
  constexpr double kSafe = 0.5;  // the response is that of an earlier position
  const Constraints& constraints = problem_.constraints();
  const Matrix response = constraints.selector().transpose() * influence_;
  return (response * constraints.curvature(multipliers_)).norm() < kSafe;
}

// u_ ← the minimiser, beginning at u_. If Φ contains an estimate of the strain rate, the estimate
// is replaced by the strain rate of the minimiser until both agree.
bool ConstrainedMinimization::solve(StepOutcome& outcome) {
  constexpr int kEstimates = 40;
  double before = std::numeric_limits<double>::infinity();
  problem_.set_rate_estimate(u_);
  if (global_freedom_count(system_) == 0) {  // x is where everything is prescribed to be
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
    if (i > 2 && residual > 0.5 * before && is_round_off(problem_, u_, residual)) {
      return true;
    }
    before = residual;
  }
  outcome.status = StepStatus::kNotConverged;
  outcome.message = "the strain rate of the viscosity does not settle";
  outcome.obstacle = StepObstacle::kViscosity;
  return false;
}

// Whether u_ solves the problem after a solve for this step, with constraint forces that have changed since.
bool ConstrainedMinimization::is_solved(StepOutcome& outcome) {
  if (outcome.minimizer.iterations == 0 || !outcome.minimizer.converged()) return false;
  problem_.set_rate_estimate(u_);
  if (!residual(gradient_).ok()) return false;
  const double left = system_.restricted_norm(gradient_);
  if (left > outcome.minimizer.residual_limit) return false;
  outcome.minimizer.residual = left;
  if (follows_loads()) problem_.take_loads(u_);
  return true;
}

EvaluationStatus ConstrainedMinimization::residual(Vector& r) const {
  return follows_loads() ? equations_.residual(u_, r) : problem_.residual(u_, r);
}

bool ConstrainedMinimization::newton_correction(Vector& correction) {
  if (follows_loads()) return root_finder_->newton_correction(equations_, u_, correction);
  Matrix moved;
  if (!problem_.residual(u_, gradient_).ok() || !solve_linear(-gradient_, moved)) return false;
  correction = moved.col(0);
  return true;
}

// Rounds with extrapolated forces and a lower accuracy first. Where they do not settle, rounds without either begin
// again.
bool ConstrainedMinimization::solve_with_multipliers(const Vector& from, StepOutcome& outcome,
                                                     const std::function<bool()>& solve,
                                                     const std::function<void()>& linearize,
                                                     int most_rounds) {
  const Vector start = u_;
  if (solve_rounds(from, outcome, solve, linearize, most_rounds, true)) return true;
  if (outcome.obstacle == StepObstacle::kViscosity || most_rounds < kRounds) return false;
  u_ = start;
  influence_.resize(0, 0);
  forget_failure(outcome);
  return solve_rounds(from, outcome, solve, linearize, most_rounds, false);
}

// Each round solves the problem with constant constraint forces, and moves to the multipliers of the problem
// linearised there. The forces of the first rounds are wrong, and so are their solutions, however small residuals
// are. The displacements under unit forces are kept as long as the rounds gain with them, also for
// the next steps, because they change slowly.
bool ConstrainedMinimization::solve_rounds(const Vector& from, StepOutcome& outcome,
                                           const std::function<bool()>& solve,
                                           const std::function<void()>& linearize, int most_rounds,
                                           bool is_quick) {
  constexpr double kAccepted = 1e-12;  // of g, and of the configuration relative to its lengths
  constexpr double kStalled = 1e-10;   // the same where round-off keeps it from falling
  constexpr double kGain = 0.2;
  constexpr double kFirst = 1e5;  // residuals of the first two rounds, in limits
  constexpr double kSecond = 10.0;
  const Constraints& constraints = problem_.constraints();
  const Vector start = constraints.configuration(from);
  const Vector lengths = constraints.configuration_lengths();
  const Vector last = constraint_force_;
  Vector force = last.size() > 0 ? last : Vector::Zero(constraints.configuration_size());
  if (is_quick && last.size() > 0 && force_before_.size() > 0) force = 2.0 * last - force_before_;
  Vector multipliers;
  Vector predicted;
  double before = std::numeric_limits<double>::infinity();
  double least = before;
  for (int round = 0; round < most_rounds; ++round) {
    apply_constraint_force(force);
    const double roughness = round == 0 ? kFirst : (round == 1 ? kSecond : 1.0);
    if (!solve_roughly(is_quick ? roughness : 1.0, solve, outcome)) return false;
    const Vector displacement = constraints.configuration((problem_.origin() - from) + u_);
    const Vector end = start + stretch_ * displacement;
    double error = constraints.values(end).cwiseAbs().maxCoeff();
    if (round > 0) {
      error = std::max(error, (end - predicted).cwiseQuotient(lengths).cwiseAbs().maxCoeff());
      if (error <= kAccepted || (error <= kStalled && !(error < 0.5 * least))) {
        constraint_force_ = force;
        force_before_ = last;
        multipliers_ = multipliers;
        return true;
      }
    }
    if (influence_.size() == 0 || error > kGain * before) {
      if (linearize) linearize();
      if (!find_influence(outcome)) return false;
    }
    before = error;
    least = std::min(least, error);
    const Matrix response = constraints.selector().transpose() * influence_;
    const MultiplierSolution solution =
        solve_multipliers(constraints, end - stretch_ * response * force, stretch_ * response,
                          start, direction_, multipliers);
    if (!solution.ok) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = cannot_be_met(constraints, solution.worst);
      outcome.obstacle = StepObstacle::kConstraints;
      return false;
    }
    multipliers = solution.multipliers;
    predicted = solution.end;
    u_ += system_.coordinates().extend(influence_ * (solution.forces - force));
    force = solution.forces;
  }
  outcome.status = StepStatus::kNotConverged;
  outcome.message = fmt::format("the multipliers did not settle in {} rounds", most_rounds);
  outcome.obstacle = StepObstacle::kConstraints;
  return false;
}

// Solves the problem up to residuals of so many times their limit.
bool ConstrainedMinimization::solve_roughly(double roughness, const std::function<bool()>& solve,
                                            StepOutcome& outcome) {
  problem_.set_roughness(roughness);
  const bool is_solved = solve();
  problem_.set_roughness(1.0);
  MinimizerReport& report = outcome.minimizer;
  report.asked_limit /= roughness;
  if (roughness > 1.0) {
    report.residual_limit = std::max(report.asked_limit, problem_.round_off(u_));
  }
  return is_solved;
}

// influence_ ← the free coordinates' displacements under unit forces on the configuration.
bool ConstrainedMinimization::find_influence(StepOutcome& outcome) {
  const Matrix forces = problem_.constraints().selector();
  influence_.resize(0, forces.cols());
  if (forces.rows() == 0) return true;
  ++outcome.minimizer.factorizations;
  if (minimizer_->solve_linearized(problem_, u_, forces, influence_)) return true;
  influence_.resize(0, 0);
  outcome.status = StepStatus::kNotConverged;
  outcome.message = "the stiffness at the minimum is not positive definite";
  return false;
}

void ConstrainedMinimization::add_constraint_potential() {
  const Constraints& constraints = problem_.constraints();
  if (!constraints.has_equations()) return;
  if (!potential_.has_stiffness()) {
    potential_.set_stiffness(system_.elastic(), system_.mesh().rest_positions(),
                             problem_.coefficient());
  }
  if (multipliers_.size() == 0) multipliers_.setZero(constraints.equation_count());
  potential_.set_multipliers(multipliers_);
  problem_.set_constraint_force({});
  problem_.set_constraint_potential(&potential_);
}

// displacements ← those under forces (3 per vertex each), by the linearised equations.
bool ConstrainedMinimization::solve_linear(const Matrix& forces, Matrix& displacements) {
  if (follows_loads()) {
    return root_finder_->solve_linearized(equations_, u_, forces, displacements);
  }
  const FreeCoordinates& coordinates = system_.coordinates();
  Matrix right(coordinates.count(), forces.cols());
  for (Index i = 0; i < forces.cols(); ++i) right.col(i) = coordinates.restrict(forces.col(i));
  Matrix solution;
  if (!minimizer_->solve_linearized(problem_, u_, right, solution)) return false;
  displacements.resize(forces.rows(), forces.cols());
  for (Index i = 0; i < forces.cols(); ++i) {
    displacements.col(i) = coordinates.extend(solution.col(i));
  }
  return displacements.allFinite();
}

// Newton's correction of positions and multipliers at u_, where gradient_ is not in balance:
//
//     H d − B G μ = −∇L,   GᵀBᵀ d = −g
//
// with the Hessian H of the augmented Lagrangian L. Returns false if H is not positive definite.
bool ConstrainedMinimization::find_correction(const Vector& g) {
  const Constraints& constraints = problem_.constraints();
  const Index count = constraints.equation_count();
  if (system_.coordinates().count() == 0) return false;
  const Matrix directions = constraints.gradients(potential_.configuration(u_));
  Matrix forces(system_.dof_count(), count + 1);
  for (Index i = 0; i < count; ++i) forces.col(i) = constraints.vertex_forces(directions.col(i));
  forces.col(count) = -gradient_;
  Matrix moved;
  if (!solve_linear(forces, moved)) return false;
  Matrix rates(count, count + 1);
  for (Index i = 0; i <= count; ++i) {
    rates.col(i) = directions.transpose() * constraints.configuration(moved.col(i));
  }
  multiplier_correction_ = solve_for_multipliers(rates.leftCols(count), -(g + rates.col(count)));
  correction_ = moved.leftCols(count) * multiplier_correction_ + moved.col(count);
  return correction_.allFinite() && multiplier_correction_.allFinite();
}

bool ConstrainedMinimization::take_saddle_point() {
  multipliers_ = potential_.total_multipliers(u_);
  constraint_force_ = problem_.constraints().gradients(potential_.configuration(u_)) * multipliers_;
  if (follows_loads()) problem_.take_loads(u_);
  return true;
}

// The saddle point of the Lagrangian: Newton's method for positions and multipliers together, as long as its
// corrections become shorter. Where they do not, and in the beginning, the augmented Lagrangian is minimised with
// constant multipliers, which then take its forces (the method of multipliers).
bool ConstrainedMinimization::solve_saddle_point(StepOutcome& outcome) {
  constexpr int kMinimizations = 40;
  constexpr double kAccepted = 1e-12;  // |g|
  constexpr double kShorter = 0.5;
  constexpr double kStiffer = 4.0;
  const Constraints& constraints = problem_.constraints();
  const double infinity = std::numeric_limits<double>::infinity();
  const Vector known = multipliers_;
  const Vector known_stiffness = potential_.stiffness();
  // A shorter step begins as this one did.
  const auto forget_failure = [&] {
    multipliers_ = known;
    potential_.restore_stiffness(known_stiffness);
  };
  Vector least;  // the last minimiser
  Vector least_multipliers;
  double violated_before = infinity;
  for (int i = 0; i < kMinimizations; ++i) {
    add_constraint_potential();
    if (!solve(outcome)) {
      forget_failure();
      return false;
    }
    least = u_;
    least_multipliers = multipliers_ = potential_.total_multipliers(u_);
    const double violated = potential_.values(u_).cwiseAbs().maxCoeff();
    if (violated > kAccepted && violated > kShorter * violated_before) {
      potential_.multiply_stiffness(kStiffer);
    }
    violated_before = violated;
    double last = infinity;  // the length of the last correction
    for (;;) {
      add_constraint_potential();
      problem_.set_rate_estimate(u_);
      if (!residual(gradient_).ok()) break;
      const Vector g = potential_.values(u_);
      const bool is_met = g.cwiseAbs().maxCoeff() <= kAccepted;
      double& left = outcome.minimizer.residual;
      left = system_.restricted_norm(gradient_);
      if (is_met && left <= outcome.minimizer.residual_limit) return take_saddle_point();
      ++outcome.minimizer.iterations;
      ++outcome.minimizer.factorizations;
      if (!find_correction(g)) break;
      const double length = correction_.lpNorm<Eigen::Infinity>();
      if (!(length < kShorter * last)) {
        if (is_met && is_round_off(problem_, u_, left)) return take_saddle_point();
        break;
      }
      last = length;
      const double share = problem_.longest_step(u_, correction_, false);
      u_ += share * correction_;
      multipliers_ += share * multiplier_correction_;
      if (!problem_.is_defined(u_)) break;
    }
    u_ = least;
    multipliers_ = least_multipliers;
  }
  outcome.status = StepStatus::kNotConverged;
  Index worst = 0;
  potential_.values(u_).cwiseAbs().maxCoeff(&worst);
  outcome.message = cannot_be_met(constraints, worst);
  outcome.obstacle = StepObstacle::kConstraints;
  forget_failure();
  return false;
}

void ConstrainedMinimization::apply_constraint_force(const Vector& u) {
  problem_.set_constraint_force(problem_.constraints().vertex_forces(u));
}

}  // namespace tetraction
