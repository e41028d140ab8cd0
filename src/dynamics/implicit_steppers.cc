// The implicit rules: one minimisation of the incremental potential a step (step_problem.h).
#include <Eigen/Geometry>
#include <utility>

#include "tetraction/dynamics/stepper.h"

namespace tetraction {
namespace {

enum class Rule { kMidpoint, kBackwardEuler };

class ImplicitStepper : public Stepper {
 public:
  ImplicitStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer, Rule rule)
      : Stepper(system), minimizer_(std::move(minimizer)), problem_(system), rule_(rule) {}

  StepOutcome step(State& state, double h) override {
    StepOutcome outcome;
    const Vector f = system_.user_force(state.time, h);
    problem_.begin(state, h, rule_ == Rule::kMidpoint ? 0.5 : 1.0, f);
    Vector x = first_guess(state);
    outcome.minimizer = minimizer_->minimize(problem_, x);
    if (!outcome.minimizer.converged()) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message = outcome.minimizer.message;
      return outcome;
    }

    double energy_at_x = 0.0;
    if (const Evaluation status = system_.potential(x, energy_at_x, gradient_); !status.ok()) {
      return inverted(outcome, status.failed_element);
    }
    State next;
    next.step = state.step + 1;
    next.time = state.time + h;
    next.velocity = (x - state.position) / problem_.step();
    system_.constraints().set_fixed_to_zero(next.velocity);
    next.position = state.position + h * next.velocity;
    next.momentum = state.momentum;
    const Vector residual = residual_at(x);
    if (rule_ == Rule::kMidpoint) {
      // Force form: inner forces add up to zero whatever the solver's tolerance is, so that linear
      // momentum is exact to round-off.
      next.momentum += h * (f - gradient_);
      system_.constraints().set_fixed_to_zero(next.momentum);
    } else {
      for (Index v = 0; v < system_.vertex_count(); ++v) {
        vertex_block(next.momentum, v) =
            system_.mass()[v] * vertex_block(std::as_const(next.velocity), v);
      }
    }
    if (!next.position.allFinite() || !next.momentum.allFinite()) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    // The midpoint rule may leave an element inverted at q_{k+1} although it is not at x.
    if (const Evaluation end = system_.elastic().value(next.position, outcome.elastic_energy);
        !end.ok()) {
      return inverted(outcome, end.failed_element);
    }

    set_reaction(gradient_, f);
    add_impulse(x, f, reaction_, h, outcome);
    outcome.external_work = h * f.dot(next.velocity);
    outcome.residual_angular_impulse = h * residual_torque(state, x, residual);
    state = std::move(next);
    return outcome;
  }

 private:
  // Of the two natural guesses (inertia alone; the last velocity kept) the one with the lower Φ.
  Vector first_guess(const State& state) const {
    Vector inertial = problem_.inertial_target();
    Vector kept = state.position + problem_.step() * state.velocity;
    for (const Index i : system_.constraints().fixed_dofs()) kept[i] = state.position[i];
    double phi_inertial = 0.0;
    double phi_kept = 0.0;
    if (!problem_.value(kept, phi_kept).ok()) return inertial;
    if (!problem_.value(inertial, phi_inertial).ok()) return kept;
    return phi_kept < phi_inertial ? kept : inertial;
  }

  // ∇Φ(x) from ∇W(x), which includes the environment's part: M(x − q_k)/s² − (p_k + s f)/s + ∇W.
  Vector residual_at(const Vector& x) const {
    Vector residual = gradient_;
    system_.constraints().set_fixed_to_zero(residual);
    const double s = problem_.step();
    const Vector3& a = system_.environment().acceleration();
    for (Index i = 0; i < x.size(); ++i) {
      if (system_.constraints().is_fixed(i)) continue;
      const double mass = system_.mass()[i / 3];
      // The target holds the environment's force as well; gradient_ does too: take it out once.
      residual[i] += mass * ((x[i] - problem_.inertial_target()[i]) / (s * s) + a[i % 3]);
    }
    return residual;
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
  Vector gradient_;
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
