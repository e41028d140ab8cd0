// Backward Euler: forces at q_{k+1}, p = M v.
#include <utility>

#include "implicit_stepper.h"

namespace tetraction {
namespace {

class BackwardEulerStepper : public ImplicitStepper {
 public:
  BackwardEulerStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer,
                       std::shared_ptr<RootFinder> root_finder)
      : ImplicitStepper(system, std::move(minimizer), std::move(root_finder), 1.0,
                        ConstraintDirection::kEnd) {}

 private:
  void set_end_position(const State& /*from*/, State& to, double /*h*/) override {
    to.position = x_;
  }
  void set_end_momentum(const State& from, State& to, const Vector& /*start*/, double h,
                        StepOutcome& outcome) override {
    const Constraints& constraints = system_.constraints();
    to.momentum = carried_;
    reactions_.configuration_force = constraint_force_;
    constraints.prescribe_momentum(to.time, to.momentum);
    if (constraints.empty()) return;
    // The part along the free coordinates, apart from the multipliers, is the solver's residual. It
    // is not a reaction.
    Vector& reaction = outer_;
    Vector& free_part = work_;
    reaction = to.momentum - from.momentum - h * force_;
    free_part = reaction;
    if (constraints.has_equations()) free_part -= impulse_;
    constraints.coordinates().project_momentum(system_.mass(), free_part);
    reaction -= free_part;
    add_reaction(to.position, 0.0, reaction, outcome);
  }
  Vector3 residual_arm(const State& /*from*/, Index v) const override {
    return vertex_block(x_, v);
  }
};

}  // namespace

std::unique_ptr<Stepper> make_backward_euler_stepper(const MechanicalSystem& system,
                                                     std::shared_ptr<Minimizer> minimizer,
                                                     std::shared_ptr<RootFinder> root_finder) {
  return std::make_unique<BackwardEulerStepper>(system, std::move(minimizer),
                                                std::move(root_finder));
}

}  // namespace tetraction
