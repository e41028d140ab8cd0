// The explicit rules: nothing is solved but the multipliers of constraints, if there are any.
#include <utility>

#include "tetraction/dynamics/multipliers.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {
namespace {

// ∇W at the current position, kept from the end of the last step.
class ForceCache {
 public:
  Evaluation update(const MechanicalSystem& system, const Vector& q) {
    if (valid_) return {};
    const Evaluation status = system.potential(q, elastic_energy_, gradient_);
    valid_ = status.ok();
    return status;
  }
  void invalidate() { valid_ = false; }
  const Vector& gradient() const { return gradient_; }
  double elastic_energy() const { return elastic_energy_; }

 private:
  bool valid_ = false;
  double elastic_energy_ = 0.0;
  Vector gradient_;
};

class ExplicitStepper : public Stepper {
 public:
  // `halves` 1: p moves by a whole step before q (α = 0); 2: by half before and half after
  // (verlet).
  ExplicitStepper(const MechanicalSystem& system, int halves) : Stepper(system), halves_(halves) {}

  void reset() override {
    force_.invalidate();
    multipliers_.resize(0);
  }

  StepOutcome step_to(State& state, double h, double end_time) override {
    StepOutcome outcome;
    if (const Evaluation start = force_.update(system_, state.position); !start.ok()) {
      return inverted(outcome, start.failed_element);
    }
    const double kick_step = halves_ == 2 ? 0.5 * h : h;
    const Vector f = system_.user_force(state.time, h);
    next_.time = end_time;
    reaction_.setZero();
    damping_.setZero(system_.dof_count());

    next_.momentum = state.momentum;
    const Vector velocity =
        system_.damping().none() ? Vector() : system_.velocity_of(state.momentum);
    kick(state.position, state.time, f, velocity, kick_step, outcome);
    if (!begin_drift(state, h, outcome)) return outcome;

    next_.velocity = system_.velocity_of(next_.momentum);
    next_.position = state.position + h * next_.velocity;
    system_.constraints().prescribe(next_.time, next_.position);
    if (!next_.position.allFinite()) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    force_.invalidate();
    if (const Evaluation end = force_.update(system_, next_.position); !end.ok()) {
      return inverted(outcome, end.failed_element);
    }
    if (halves_ == 2) {
      const Vector predicted =
          system_.damping().none() ? Vector() : predicted_velocity(f, kick_step);
      kick(next_.position, next_.time, f, predicted, kick_step, outcome);
    }
    end_drift(h, outcome);
    if (!next_.momentum.allFinite()) {
      force_.invalidate();
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    finish(state, h, f, outcome);
    std::swap(state, next_);
    return outcome;
  }

 private:
  // p += dt (f − ∇W + damping + springs) at positions q; `velocity` is of the damping.
  void kick(const Vector& q, double time, const Vector& user_force, const Vector& velocity,
            double dt, StepOutcome& outcome) {
    next_.momentum += dt * (user_force - force_.gradient());
    Vector outer = user_force;
    Vector slope = Vector::Zero(system_.dof_count());
    system_.environment().add_gradient(system_.mass(), q, slope);
    outer -= slope;
    if (system_.constraints().has_springs()) {
      const Vector springs = spring_force(q, time);
      next_.momentum += dt * springs;
      outer += springs;
      reaction_ += dt * springs;
    }
    if (!system_.damping().none()) {
      Vector damping = system_.drag_force(velocity);
      outer += damping;
      system_.add_viscous_force(q, velocity, damping);
      next_.momentum += dt * damping;
      damping_ += dt * damping;
    }
    add_impulse(q, outer, dt, outcome);
  }

  // What the momenta have to carry through the step, so that it ends on the constraints.
  bool begin_drift(const State& state, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return true;
    const Vector before = next_.momentum;
    constraints.coordinates().project_momentum(system_.mass(), next_.momentum);
    if (constraints.moving()) {
      const Vector moved = constraints.prescribed_displacement(state.position, next_.time);
      for (Index i = 0; i < moved.size(); ++i) {
        next_.momentum[i] += system_.mass()[i / 3] * moved[i] / h;
      }
    }
    if (constraints.has_equations()) {
      const Vector start = constraints.configuration(state.position);
      const Vector free_end =
          start + h * constraints.configuration(system_.velocity_of(next_.momentum));
      const MultiplierSolution solution =
          solve_multipliers(constraints, free_end, h * constraints.inverse_mass(), start,
                            ConstraintDirection::kStart, multipliers_);
      if (!solution.ok) {
        outcome.status = StepStatus::kNotConverged;
        outcome.message = cannot_be_met(constraints, solution.worst);
        return false;
      }
      multipliers_ = solution.multipliers;
      configuration_force_ = solution.forces / h;
      Vector impulse = constraints.vertex_forces(solution.forces);
      constraints.coordinates().project_momentum(system_.mass(), impulse);
      next_.momentum += impulse;
    }
    add_reaction(state.position, next_.momentum - before, outcome);
    return true;
  }

  // Momenta that keep the constraints at the end of the step.
  void end_drift(double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    if (constraints.empty()) return;
    const Vector before = next_.momentum;
    const Vector impulses = project_to_constraints(constraints, system_.mass(), next_.position,
                                                   next_.time, next_.momentum);
    if (impulses.size() > 0) configuration_force_ += impulses / h;
    add_reaction(next_.position, next_.momentum - before, outcome);
  }

  // The velocity at the end of the step as a first kick with the drift's own velocity gives it:
  // second order, which is what the damping force of verlet needs.
  Vector predicted_velocity(const Vector& user_force, double dt) const {
    Vector force = user_force - force_.gradient() + system_.drag_force(next_.velocity) +
                   spring_force(next_.position, next_.time);
    system_.add_viscous_force(next_.position, next_.velocity, force);
    Vector momentum = next_.momentum + dt * force;
    if (!system_.constraints().empty()) {
      project_to_constraints(system_.constraints(), system_.mass(), next_.position, next_.time,
                             momentum);
    }
    return system_.velocity_of(momentum);
  }

  void finish(const State& state, double h, const Vector& user_force, StepOutcome& outcome) {
    reaction_ /= h;
    const Constraints& constraints = system_.constraints();
    if (constraints.empty() && system_.damping().none()) {
      outcome.external_work = h * user_force.dot(next_.velocity);
    } else {
      next_.velocity = (next_.position - state.position) / h;
      outcome.external_work = h * user_force.dot(next_.velocity);
      outcome.dissipated_energy = -damping_.dot(next_.velocity);
      outcome.constraint_work = constraint_work(state, next_);
    }
    outcome.elastic_energy = force_.elastic_energy();
    next_.step = state.step + 1;
  }

  StepOutcome inverted(StepOutcome& outcome, Index element) {
    force_.invalidate();
    outcome.status = StepStatus::kInverted;
    outcome.element = element;
    return outcome;
  }

  int halves_;
  ForceCache force_;
  State next_;      // kept to spare allocations
  Vector damping_;  // impulse of the damping forces in this step
  Vector multipliers_;
};

}  // namespace

std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 1);
}

std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 2);
}

}  // namespace tetraction
