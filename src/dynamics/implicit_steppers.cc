// The implicit rules: one minimisation of the incremental potential a step (step_problem.h), or a
// few where multipliers have to be found with it.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "first_guess.h"
#include "tetraction/dynamics/multipliers.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {
namespace {

enum class Rule { kMidpoint, kBackwardEuler };

class ImplicitStepper : public Stepper {
 public:
  ImplicitStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer, Rule rule)
      : Stepper(system),
        minimizer_(std::move(minimizer)),
        problem_(system),
        guess_(system),
        rule_(rule) {}

  void reset() override {
    constraint_force_.resize(0);
    guess_.reset();
  }

  StepOutcome step_to(State& state, double h, double end_time) override {
    StepOutcome outcome;
    system_.external_force(state.time, h, load_);
    reaction_.setZero();
    problem_.begin(state, h, end_time, rule_ == Rule::kMidpoint ? 0.5 : 1.0, load_);
    if (!find(state, end_time, outcome)) return outcome;

    next_.step = state.step + 1;
    next_.time = end_time;
    problem_.positions(u_, x_);
    // The change of position before it is rounded to a position.
    next_.velocity = ((problem_.origin() - state.position) + u_) / problem_.step();
    if (rule_ == Rule::kMidpoint) {
      next_.position = state.position + h * next_.velocity;
    } else {
      next_.position = x_;
    }
    system_.constraints().prescribe(next_.time, next_.position);
    if (!take_momenta(state, h, outcome)) return outcome;
    if (!next_.position.allFinite() || !next_.momentum.allFinite()) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    // The midpoint rule may leave an element inverted at q_{k+1} although it is not at x; and the energy
    // is that of the rounded positions, which an edit between two steps finds, too.
    const Evaluation end = system_.elastic().value(next_.position, outcome.elastic_energy);
    if (!end.ok()) return inverted(outcome, end.failed_element);
    Index vertex = -1;
    const ForceTerm* term = system_.undefined_term(next_.position, next_.time, vertex);
    if (term != nullptr) return undefined(outcome, *term, vertex);
    if (load_.size() > 0) outcome.external_work = load_.dot(next_.position - state.position);
    outcome.external_work += driven_work(state, next_);
    if (system_.is_dissipative()) outcome.dissipated_energy = problem_.dissipated_energy(u_, h);
    reaction_ /= h;
    outcome.constraint_work = constraint_work(state, next_);
    if (constraining_) reaction_ += spring_force_;
    guess_.keep(state.velocity, outcome.elastic_energy);
    std::swap(state, next_);
    return outcome;
  }

 private:
  // u_ ← the minimiser of the step, or the outcome says why there is none.
  bool find(const State& state, double end_time, StepOutcome& outcome) {
    using Quality = FirstGuess::Quality;
    Quality guess = guess_.choose(problem_, state);
    u_.setZero(system_.dof_count());
    const bool led = guess != Quality::kGood;
    if (led && !lead_along(state, end_time, outcome)) {
      if (guess == Quality::kUndefined) return false;
      // Materials that may be turned inside out go on from a poor guess.
      outcome.status = StepStatus::kOk;
      outcome.message.clear();
      problem_.prescribe_base(end_time);
      guess_.choose(problem_, state);
      u_.setZero();
    }
    if (minimize(state, outcome)) return true;
    // From a guess that is not led along, a body with moving parts may end in a dead end.
    if (led || !system_.constraints().moving()) return false;
    StepOutcome again;
    again.minimizer.iterations = outcome.minimizer.iterations;
    again.minimizer.factorizations = outcome.minimizer.factorizations;
    again.minimizer.cg_iterations = outcome.minimizer.cg_iterations;
    problem_.set_impulse({});
    u_.setZero(system_.dof_count());
    if (!lead_along(state, end_time, again) || !minimize(state, again)) return false;
    outcome = again;
    return true;
  }

  bool minimize(const State& state, StepOutcome& outcome) {
    return system_.constraints().has_equations() ? solve_constrained(state, outcome)
                                                 : solve(outcome);
  }

  // Moves what is prescribed a part of its way at a time. The body is led along by a harmonic
  // extension and comes to its minimum each time, so that nothing is crushed or inverted by a motion
  // of more than an element a step.
  bool lead_along(const State& state, double end_time, StepOutcome& outcome) {
    constexpr double kLeastPart = 1.0 / 512;
    if (!system_.constraints().moving()) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = "the elastic energy is not defined at the start of the step";
      return false;
    }
    x_ = state.position;
    double done = 0.0;
    double part = 1.0;
    while (done < 1.0) {
      const double next = std::min(1.0, done + part);
      problem_.prescribe_base(next < 1.0 ? state.time + next * (end_time - state.time) : end_time);
      trial_ = x_;
      guess_.carry_along(problem_, trial_);
      problem_.set_origin(trial_);
      u_.setZero();
      double phi = 0.0;
      bool good = problem_.value(u_, phi).ok() && guess_.keeps_volumes(x_, trial_);
      if (good && next < 1.0) good = solve(outcome);
      if (good) {
        problem_.positions(u_, x_);
        done = next;
        part *= 2.0;
      } else {
        part *= 0.5;
      }
      if (part < kLeastPart) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message =
            "what moves as prescribed would crush the elements beside it, however it is led there: "
            "take a smaller step";
        return false;
      }
    }
    outcome.status = StepStatus::kOk;
    outcome.message.clear();
    return true;
  }

  static constexpr double kOverEstimate = 100.0;  // of round-off: what is taken for it

  // One call of the minimiser, and what it did on top of what was done before.
  MinimizerReport call_minimizer(StepOutcome& outcome) {
    const MinimizerReport report = minimizer_->minimize(problem_, u_);
    const int iterations = outcome.minimizer.iterations;
    const int factorizations = outcome.minimizer.factorizations;
    const int cg_iterations = outcome.minimizer.cg_iterations;
    outcome.minimizer = report;
    outcome.minimizer.cg_iterations += cg_iterations;
    outcome.minimizer.iterations += iterations;
    outcome.minimizer.factorizations += factorizations;
    return report;
  }

  // u_ ← the minimiser, beginning at u_. An estimate of the strain rate is replaced by what came out
  // until both agree.
  bool solve(StepOutcome& outcome) {
    constexpr int kEstimates = 40;
    double before = std::numeric_limits<double>::infinity();
    problem_.set_rate_estimate(u_);
    if (system_.coordinates().count() == 0) {  // x is where everything is prescribed to be
      outcome.minimizer.termination = Termination::kConverged;
      outcome.minimizer.message = "nothing to solve for: every vertex is held";
      return true;
    }
    for (int i = 0; i < kEstimates; ++i) {
      const MinimizerReport report = minimize_to_round_off(outcome);
      if (!report.converged()) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = report.message;
        return false;
      }
      if (!problem_.needs_rate_estimate()) return true;
      problem_.set_rate_estimate(u_);
      double phi = 0.0;
      if (!problem_.value_and_full_gradient(u_, phi, force_).ok()) break;
      const double residual = system_.coordinates().restricted_norm(force_);
      outcome.minimizer.residual = residual;
      if (residual <= std::max(report.residual, report.residual_limit)) return true;
      // Where it falls no further, what remains is round-off.
      if (i > 2 && residual > 0.5 * before && residual <= kOverEstimate * problem_.round_off(u_)) {
        return true;
      }
      before = residual;
    }
    outcome.status = StepStatus::kNotConverged;
    outcome.message = "the strain rate of the viscosity does not settle: take a smaller step";
    return false;
  }

  // Displacements from the origin have round-off of their own. Where that keeps the minimiser from
  // what was asked for, the origin is moved to where it came. What remains then is the best that can be
  // had: the step goes on with it, and its report says so (MinimizerReport::limited_by_round_off).
  MinimizerReport minimize_to_round_off(StepOutcome& outcome) {
    constexpr int kMoves = 4;
    MinimizerReport report = call_minimizer(outcome);
    for (int i = 0; i < kMoves && report.termination == Termination::kNoProgress; ++i) {
      const double before = report.residual;
      problem_.move_origin(u_);
      report = call_minimizer(outcome);
      if (i > 0 && report.residual > 0.5 * before) break;
    }
    if (report.termination != Termination::kNoProgress) return report;
    problem_.move_origin(u_);
    if (report.residual <= kOverEstimate * problem_.round_off(u_)) {
      report.termination = outcome.minimizer.termination = Termination::kConverged;
    }
    return report;
  }

  // Newton's method on position and multipliers together. Each round moves both to where the problem
  // linearised at x meets the constraints; where that does not lower the residual, Φ is minimised
  // with the constraint forces held before the next round.
  bool solve_constrained(const State& state, StepOutcome& outcome) {
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
      const Vector way = constraints.configuration((problem_.origin() - state.position) + u_);
      const Vector free_end = start + stretch * (way - response * u);
      const MultiplierSolution solution = solve_multipliers(
          constraints, free_end, stretch * response, start,
          midpoint ? ConstraintDirection::kStart : ConstraintDirection::kEnd, multipliers);
      if (!solution.ok && !minimize) {
        u_ += system_.coordinates().extend(influence.col(size));
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
      u_ += system_.coordinates().extend(influence.leftCols(size) * (solution.forces - u));
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

  bool take_momenta(const State& state, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    const double s = problem_.step();
    const Vector* gradient = nullptr;
    if (const Evaluation status = problem_.elastic_gradient(u_, gradient); !status.ok()) {
      inverted(outcome, status.failed_element);
      return false;
    }
    gather_forces(state.time + s, state.position, *gradient);
    add_impulse(x_, outer_, h, outcome);

    // p⁺: the momenta after the impulses of the multipliers at q_k (midpoint).
    const bool impulse_first = constraints.has_equations() && rule_ == Rule::kMidpoint;
    if (impulse_first) start_ = state.momentum + impulse_;
    const Vector& start = impulse_first ? start_ : state.momentum;
    system_.momentum_of(next_.velocity, carried_);

    Vector& residual = work_;
    residual = (carried_ - start) / s - force_;
    if (constraints.has_equations() && !impulse_first) residual -= impulse_ / s;
    constraints.coordinates().project_momentum(system_.mass(), residual);
    outcome.residual_angular_impulse = h * residual_torque(state, residual);

    if (rule_ == Rule::kMidpoint) {
      // Force form: inner forces add up to zero whatever the solver's tolerance is, so that linear
      // momentum is exact to round-off.
      next_.momentum = start + h * force_;
      if (!constraints.empty()) constrain_momenta(state, start, h, outcome);
    } else {
      next_.momentum = carried_;
      configuration_force_ = constraint_force_;
      constraints.prescribe_momentum(next_.time, next_.momentum);
      if (!constraints.empty()) {
        // What the free coordinates keep beside the multipliers is the solver's residual, not a
        // reaction.
        Vector& reaction = outer_;
        Vector& free_part = work_;
        reaction = next_.momentum - state.momentum - h * force_;
        free_part = reaction;
        if (constraints.has_equations()) free_part -= impulse_;
        constraints.coordinates().project_momentum(system_.mass(), free_part);
        reaction -= free_part;
        add_reaction(next_.position, reaction, outcome);
      }
    }
    return true;
  }

  // outer_ ← the forces at x_ that change the body's momentum, force_ ← all forces, damping_ ← those
  // of damping, spring_force_ ← those of terms that stand for constraints. `gradient`: of the elastic
  // energy; `previous`: q_k.
  void gather_forces(double time, const Vector& previous, const Vector& gradient) {
    outer_.setZero(system_.dof_count());
    constraining_ = false;
    const ForcePoint at = system_.force_point(x_, time);
    for (const ForceTerm* term : system_.force_terms()) {
      if (!term->has_potential()) continue;
      const bool constraint = term->account() == EnergyAccount::kConstraintWork;
      if (constraint && !constraining_) spring_force_.setZero(system_.dof_count());
      constraining_ = constraining_ || constraint;
      term->add_gradient(at, constraint ? spring_force_ : outer_);
    }
    outer_ = -outer_;
    if (load_.size() > 0) outer_ += load_;
    if (constraining_) {
      spring_force_ = -spring_force_;
      outer_ += spring_force_;
    }
    force_ = outer_ - gradient;
    if (!system_.is_dissipative()) return;
    // First the gradient of the viscous potential, which its forces point against.
    damping_.setZero(system_.dof_count());
    double ignored = 0.0;
    problem_.viscous().add_value_and_gradient(problem_.step_displacement(u_), ignored, damping_);
    damping_ = -damping_;
    // Dissipation potentials of terms are taken at the positions at the beginning of the step.
    system_.add_damping_force(previous, time, next_.velocity, damping_);
    system_.add_damping_force(previous, time, next_.velocity, outer_);
    force_ += damping_;
  }

  // The midpoint rule's momenta at q_{k+1}, with the reactions of the constraints.
  void constrain_momenta(const State& state, const Vector& start, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    const FreeCoordinates& free = constraints.coordinates();
    const Vector& mass = system_.mass();
    // Eliminated directions: the momenta that carry the vertices through the step.
    Vector& eliminated = carried_;
    work_ = carried_;
    free.project_momentum(mass, work_);
    eliminated -= work_;
    Vector& unconstrained = force_;
    unconstrained = next_.momentum;
    free.project_momentum(mass, next_.momentum);
    next_.momentum += eliminated;
    Vector& first = outer_;
    first = start;
    free.project_momentum(mass, first);
    first += eliminated;
    // At q_k: multipliers and the jump of prescribed vertices to their secant.
    work_ = first - state.momentum;
    add_reaction(state.position, work_, outcome);
    work_ = next_.momentum - first - (unconstrained - start);
    add_reaction(x_, work_, outcome);
    work_ = next_.momentum;
    const Vector impulses =
        project_to_constraints(constraints, mass, next_.position, next_.time, next_.momentum);
    if (impulses.size() > 0) {
      configuration_force_ = problem_.step() / h * constraint_force_ + impulses / h;
    }
    work_ = next_.momentum - work_;
    add_reaction(next_.position, work_, outcome);
  }

  double residual_torque(const State& state, const Vector& residual) const {
    Vector3 torque = Vector3::Zero();
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      Vector3 arm = vertex_block(x_, v);
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
  FirstGuess guess_;
  Rule rule_;
  Vector impulse_;           // of the multipliers, per vertex
  Vector constraint_force_;  // on the configuration, of the last step
  // Kept to spare allocations.
  State next_;
  Vector u_;  // from the problem's origin
  Vector x_;
  Vector trial_;
  Vector load_;  // empty: none
  Vector spring_force_;
  bool constraining_ = false;  // some term stands for a constraint
  Vector outer_;
  Vector force_;
  Vector damping_;
  Vector carried_;  // M v
  Vector start_;
  Vector work_;
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
