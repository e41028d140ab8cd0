// The midpoint rule, α = ½.
#include <utility>

#include "implicit_stepper.h"

namespace tetraction {
namespace {

class MidpointStepper : public ImplicitStepper {
 public:
  MidpointStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer)
      : ImplicitStepper(system, std::move(minimizer), 0.5, ConstraintDirection::kStart) {}

 private:
  void set_end_position(const State& state, double h) override {
    next_.position = state.position + h * next_.velocity;
  }
  // The momenta are computed from the forces. Internal forces add up to zero whatever the solver's
  // tolerance is, so that linear momentum is exact to round-off.
  void set_end_momentum(const State& state, const Vector& start, double h,
                        StepOutcome& outcome) override {
    next_.momentum = start + h * force_;
    if (!system_.constraints().empty()) constrain_momenta(state, start, h, outcome);
  }
  Vector3 residual_arm(const State& state, Index v) const override {
    return vertex_block(x_, v) - vertex_block(state.position, v);
  }

  // The momenta at q_{k+1} with the reactions of the constraints.
  void constrain_momenta(const State& state, const Vector& start, double h, StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    const FreeCoordinates& free = constraints.coordinates();
    const Vector& mass = system_.mass();
    // In eliminated directions these are the momenta of the vertices' displacement in the step.
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
      configuration_force_ = problem().step() / h * constraint_force_ + impulses / h;
    }
    work_ = next_.momentum - work_;
    add_reaction(next_.position, work_, outcome);
  }
};

}  // namespace

std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer) {
  return std::make_unique<MidpointStepper>(system, std::move(minimizer));
}

}  // namespace tetraction
