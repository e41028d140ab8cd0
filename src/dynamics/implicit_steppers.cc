// The implicit rules: one minimisation of the incremental potential a step (step_problem.h), or a
// few where multipliers have to be found with it.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <limits>
#include <utility>
#include <vector>

#include "tetraction/dynamics/multipliers.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {
namespace {

enum class Rule { kMidpoint, kBackwardEuler };

class ImplicitStepper : public Stepper {
 public:
  ImplicitStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer, Rule rule)
      : Stepper(system), minimizer_(std::move(minimizer)), problem_(system), rule_(rule) {}

  void reset() override {
    constraint_force_.resize(0);
    earlier_.clear();
  }

  StepOutcome step_to(State& state, double h, double end_time) override {
    StepOutcome outcome;
    const Vector f = system_.user_force(state.time, h);
    reaction_.setZero();
    problem_.begin(state, h, end_time, rule_ == Rule::kMidpoint ? 0.5 : 1.0, f);
    Vector x = first_guess(state);
    const bool solved = system_.constraints().has_equations() ? solve_constrained(state, x, outcome)
                                                              : solve(x, outcome);
    if (!solved) return outcome;

    State next;
    next.step = state.step + 1;
    next.time = end_time;
    next.velocity = (x - state.position) / problem_.step();
    next.position = state.position + h * next.velocity;
    system_.constraints().prescribe(next.time, next.position);
    if (!take_momenta(state, x, h, f, next, outcome)) return outcome;
    if (!next.position.allFinite() || !next.momentum.allFinite()) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    // The midpoint rule may leave an element inverted at q_{k+1} although it is not at x.
    if (const Evaluation end = system_.elastic().value(next.position, outcome.elastic_energy);
        !end.ok()) {
      return inverted(outcome, end.failed_element);
    }
    const Vector moved = next.position - state.position;
    outcome.external_work = f.dot(moved);
    outcome.dissipated_energy = -damping_.dot(moved);
    reaction_ /= h;
    outcome.constraint_work = constraint_work(state, next);
    if (system_.constraints().has_springs()) {
      reaction_ += spring_force(x, state.time + problem_.step());
    }
    earlier_.insert(earlier_.begin(), std::move(state.velocity));
    if (earlier_.size() > 2) earlier_.pop_back();
    state = std::move(next);
    return outcome;
  }

 private:
  // Of the natural guesses (inertia alone; the last velocity kept, or going on to change as it did)
  // the one with the lowest Φ.
  Vector first_guess(const State& state) {
    Vector best = problem_.inertial_guess();
    double least = std::numeric_limits<double>::infinity();
    if (!problem_.value(best, least).ok()) least = std::numeric_limits<double>::infinity();
    Vector velocity = state.velocity;
    for (std::size_t order = 0; order <= earlier_.size(); ++order) {
      // Polynomials through the last velocities, equal steps taken for granted.
      if (order == 1) velocity = 2.0 * state.velocity - earlier_[0];
      if (order == 2) velocity = 3.0 * (state.velocity - earlier_[0]) + earlier_[1];
      Vector displacement = problem_.step() * velocity;
      system_.coordinates().project_velocity(system_.mass(), displacement);
      displacement += problem_.base();
      double phi = 0.0;
      if (problem_.value(displacement, phi).ok() && phi < least) {
        least = phi;
        best.swap(displacement);
      }
    }
    return best;
  }

  bool solve(Vector& x, StepOutcome& outcome) {
    const MinimizerReport report = minimizer_->minimize(problem_, x);
    const int iterations = outcome.minimizer.iterations;
    const int factorizations = outcome.minimizer.factorizations;
    const int cg_iterations = outcome.minimizer.cg_iterations;
    outcome.minimizer = report;
    outcome.minimizer.cg_iterations += cg_iterations;
    outcome.minimizer.iterations += iterations;
    outcome.minimizer.factorizations += factorizations;
    if (report.converged()) return true;
    outcome.status = StepStatus::kNotConverged;
    outcome.message = report.message;
    return false;
  }

  // Newton's method on position and multipliers together. Each round moves both to where the problem
  // linearised at x meets the constraints; where that does not lower the residual, Φ is minimised
  // with the constraint forces held before the next round.
  bool solve_constrained(const State& state, Vector& x, StepOutcome& outcome) {
    constexpr int kRounds = 40;
    const Constraints& constraints = system_.constraints();
    const bool midpoint = rule_ == Rule::kMidpoint;
    const double stretch = midpoint ? 2.0 : 1.0;  // of q_{k+1} − q_k over x − q_k
    const Index size = constraints.configuration_size();
    const Vector start = constraints.configuration(state.position);
    Vector u = constraint_force_.size() > 0 ? constraint_force_ : Vector::Zero(size);
    Vector multipliers;
    double last_residual = std::numeric_limits<double>::infinity();
    bool minimize = true;
    for (int round = 0; round < kRounds; ++round) {
      apply(u);
      Matrix right(system_.coordinates().count(), size + 1);
      right.leftCols(size) = constraints.selector();
      right.col(size).setZero();
      double phi = 0.0;
      Vector gradient;
      if (round > 0) {
        minimize = true;
        if (problem_.value_and_gradient(x, phi, gradient).ok()) {
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
        if (!solve(x, outcome)) return false;
        right.col(size).setZero();
        last_residual = std::numeric_limits<double>::infinity();
      } else {
        ++outcome.minimizer.iterations;
      }
      Matrix influence;  // of u on the free coordinates at x; last column: Newton's step
      ++outcome.minimizer.factorizations;
      if (!minimizer_->solve_linearized(problem_, x, right, influence)) {
        if (!minimize) {
          last_residual = 0.0;  // minimise from here
          continue;
        }
        outcome.status = StepStatus::kNotConverged;
        outcome.message = "the stiffness at the minimum is not positive definite";
        return false;
      }
      x -= system_.coordinates().extend(influence.col(size));
      const Matrix response = constraints.selector().transpose() * influence.leftCols(size);
      const Vector at_x = constraints.configuration(x);
      const Vector free_end = start + stretch * (at_x - response * u - start);
      const MultiplierSolution solution = solve_multipliers(
          constraints, free_end, stretch * response, start,
          midpoint ? ConstraintDirection::kStart : ConstraintDirection::kEnd, multipliers);
      if (!solution.ok && !minimize) {
        x += system_.coordinates().extend(influence.col(size));
        last_residual = 0.0;  // minimise from here
        multipliers.resize(0);
        continue;
      }
      if (!solution.ok) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = cannot_be_met(constraints, solution.worst);
        return false;
      }
      multipliers = solution.multipliers;
      x += system_.coordinates().extend(influence.leftCols(size) * (solution.forces - u));
      u = solution.forces;
    }
    outcome.status = StepStatus::kNotConverged;
    outcome.message = fmt::format("the multipliers did not settle in {} rounds", kRounds);
    return false;
  }

  void apply(const Vector& u) {
    impulse_ = problem_.step() * system_.constraints().vertex_forces(u);
    problem_.set_impulse(impulse_);
  }

  bool take_momenta(const State& state, const Vector& x, double h, const Vector& user_force,
                    State& next, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    const double s = problem_.step();
    double energy = 0.0;
    Vector gradient;
    if (const Evaluation status = system_.elastic().value_and_gradient(x, energy, gradient);
        !status.ok()) {
      inverted(outcome, status.failed_element);
      return false;
    }
    // Forces that change the body's momentum, and all of them.
    Vector slope = Vector::Zero(system_.dof_count());
    system_.environment().add_gradient(system_.mass(), x, slope);
    Vector outer = user_force - slope + spring_force(x, state.time + s);
    const Vector velocity = (x - state.position) / s;
    damping_.setZero(system_.dof_count());
    if (!system_.damping().none()) {
      damping_ = system_.drag_force(velocity);
      outer += damping_;
      double ignored = 0.0;
      Vector viscous = Vector::Zero(system_.dof_count());
      problem_.viscous().add_value_and_gradient(x, ignored, viscous);
      damping_ -= viscous;
    }
    Vector force = user_force - slope + spring_force(x, state.time + s) + damping_ - gradient;

    // p⁺: the momenta after the impulses of the multipliers at q_k (midpoint).
    Vector start = state.momentum;
    if (constraints.has_equations() && rule_ == Rule::kMidpoint) start += impulse_;
    const Vector carried = system_.momentum_of(velocity);

    Vector residual = (carried - start) / s - force;
    if (constraints.has_equations() && rule_ == Rule::kBackwardEuler) residual -= impulse_ / s;
    constraints.coordinates().project_momentum(system_.mass(), residual);

    add_impulse(x, outer, h, outcome);
    if (rule_ == Rule::kMidpoint) {
      // Force form: inner forces add up to zero whatever the solver's tolerance is, so that linear
      // momentum is exact to round-off.
      next.momentum = start + h * force;
      if (!constraints.empty()) {
        Vector before = next.momentum;
        // Eliminated directions: the momenta that carry the vertices through the step.
        constraints.coordinates().project_momentum(system_.mass(), next.momentum);
        Vector held = carried;
        constraints.coordinates().project_momentum(system_.mass(), held);
        next.momentum += carried - held;
        Vector first = start;
        constraints.coordinates().project_momentum(system_.mass(), first);
        first += carried - held;
        // At q_k: multipliers and the jump of prescribed vertices to their secant.
        add_reaction(state.position, first - state.momentum, outcome);
        add_reaction(x, next.momentum - first - (before - start), outcome);
        before = next.momentum;
        const Vector impulses = project_to_constraints(constraints, system_.mass(), next.position,
                                                       next.time, next.momentum);
        if (impulses.size() > 0) configuration_force_ = s / h * constraint_force_ + impulses / h;
        add_reaction(next.position, next.momentum - before, outcome);
      }
    } else {
      next.momentum = carried;
      configuration_force_ = constraint_force_;
      constraints.prescribe_momentum(next.time, next.momentum);
      if (!constraints.empty()) {
        // What the free coordinates keep beside the multipliers is the solver's residual, not a
        // reaction.
        Vector reaction = next.momentum - state.momentum - h * force;
        Vector free_part = reaction;
        if (constraints.has_equations()) free_part -= impulse_;
        constraints.coordinates().project_momentum(system_.mass(), free_part);
        add_reaction(next.position, reaction - free_part, outcome);
      }
    }
    outcome.residual_angular_impulse = h * residual_torque(state, x, residual);
    return true;
  }

  double residual_torque(const State& state, const Vector& x, const Vector& residual) const {
    Vector3 torque = Vector3::Zero();
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      Vector3 arm = vertex_block(x, v);
      if (rule_ == Rule::kMidpoint) arm -= vertex_block(state.position, v);
      torque += arm.cross(vertex_block(residual, v));
    }
    return torque.norm();
  }

  static StepOutcome inverted(StepOutcome& outcome, Index element) {
    outcome.status = StepStatus::kInverted;
    outcome.element = element;
    return outcome;
  }

  std::shared_ptr<Minimizer> minimizer_;
  StepProblem problem_;
  Rule rule_;
  std::vector<Vector> earlier_;  // velocities of the steps before the last one
  Vector damping_;               // damping forces of this step
  Vector impulse_;               // of the multipliers, per vertex
  Vector constraint_force_;      // on the configuration, of the last step
};

}  // namespace

std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer) {
  return std::make_unique<ImplicitStepper>(system, std::move(minimizer), Rule::kMidpoint);
}

std::unique_ptr<Stepper> make_backward_euler_stepper(const MechanicalSystem& system,
                                                     std::shared_ptr<Minimizer> minimizer) {
  return std::make_unique<ImplicitStepper>(system, std::move(minimizer), Rule::kBackwardEuler);
}

}  // namespace tetraction
