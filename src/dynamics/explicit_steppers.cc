// The explicit rules: nothing is solved.
#include <utility>

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

  void reset() override { force_.invalidate(); }

  StepOutcome step(State& state, double h) override {
    StepOutcome outcome;
    if (const Evaluation start = force_.update(system_, state.position); !start.ok()) {
      return inverted(outcome, start.failed_element);
    }
    const Vector f = system_.user_force(state.time, h);
    const double kick_step = halves_ == 2 ? 0.5 * h : h;

    next_.momentum = state.momentum;
    kick(f, kick_step, next_.momentum);
    set_reaction(force_.gradient(), f);
    add_impulse(state.position, f, reaction_, kick_step, outcome);

    next_.velocity.resize(system_.dof_count());
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      vertex_block(next_.velocity, v) =
          vertex_block(std::as_const(next_.momentum), v) / system_.mass()[v];
    }
    next_.position = state.position + h * next_.velocity;
    if (!next_.position.allFinite()) {
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    outcome.external_work = h * f.dot(next_.velocity);

    force_.invalidate();
    if (const Evaluation end = force_.update(system_, next_.position); !end.ok()) {
      return inverted(outcome, end.failed_element);
    }
    if (halves_ == 2) {
      kick(f, kick_step, next_.momentum);
      const Vector first_reaction = reaction_;
      set_reaction(force_.gradient(), f);
      add_impulse(next_.position, f, reaction_, kick_step, outcome);
      reaction_ = 0.5 * (first_reaction + reaction_);
    }
    if (!next_.momentum.allFinite()) {
      force_.invalidate();
      outcome.status = StepStatus::kNotFinite;
      return outcome;
    }
    outcome.elastic_energy = force_.elastic_energy();
    next_.step = state.step + 1;
    next_.time = state.time + h;
    std::swap(state, next_);
    return outcome;
  }

 private:
  // p += h (f − ∇W) at the free DOFs.
  void kick(const Vector& user_force, double h, Vector& momentum) const {
    momentum += h * (user_force - force_.gradient());
    system_.constraints().set_fixed_to_zero(momentum);
  }

  StepOutcome inverted(StepOutcome& outcome, Index element) {
    force_.invalidate();
    outcome.status = StepStatus::kInverted;
    outcome.element = element;
    return outcome;
  }

  int halves_;
  ForceCache force_;
  State next_;  // kept to spare allocations
};

}  // namespace

std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 1);
}

std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system) {
  return std::make_unique<ExplicitStepper>(system, 2);
}

}  // namespace tetraction
