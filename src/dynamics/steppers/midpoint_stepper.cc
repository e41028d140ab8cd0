// The midpoint rule: formula (11) of docs/theory.md with α = ½.
#include <utility>

#include "implicit_stepper.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

class MidpointStepper : public ImplicitStepper {
 public:
  MidpointStepper(const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer,
                  std::shared_ptr<RootFinder> root_finder)
      : ImplicitStepper(system, std::move(minimizer), std::move(root_finder), 0.5,
                        ConstraintDirection::kStart) {}

 private:
  void set_end_position(const State& from, State& to, double h) override {
    to.position = from.position + h * to.velocity;
  }
  // The momenta are computed from the forces. Internal forces add up to zero whatever the solver's
  // tolerance is, so that linear momentum is exact to round-off.
  void set_end_momentum(const State& from, State& to, const Vector& start, double h,
                        StepOutcome& outcome) override {
    to.momentum = start + h * force_;
    if (!system_.constraints().empty()) constrain_momenta(from, to, start, h, outcome);
  }
  Vector3 residual_arm(const State& from, Index v) const override {
    return vertex_block(x_, v) - vertex_block(from.position, v);
  }

  // The momenta at q_{k+1} with the reactions of the constraints.
  void constrain_momenta(const State& from, State& to, const Vector& start, double h,
                         StepOutcome& outcome) {
    const Constraints& constraints = system_.constraints();
    const FreeCoordinates& free = constraints.coordinates();
    const Vector& mass = system_.mass();
    // In eliminated directions these are the momenta of the vertices' displacement in the step.
    Vector& eliminated = carried_;
    work_ = carried_;
    free.project_momentum(mass, work_);
    eliminated -= work_;
    Vector& unconstrained = force_;
    unconstrained = to.momentum;
    free.project_momentum(mass, to.momentum);
    to.momentum += eliminated;
    Vector& first = outer_;
    first = start;
    free.project_momentum(mass, first);
    first += eliminated;
    // At q_k: multipliers and the jump of prescribed vertices to their secant.
    work_ = first - from.momentum;
    add_reaction(from.position, h, work_, outcome);
    work_ = to.momentum - first - (unconstrained - start);
    add_reaction(x_, 0.5 * h, work_, outcome);
    work_ = to.momentum;
    const Vector impulses =
        project_to_constraints(constraints, mass, to.position, to.time, to.momentum);
    if (impulses.size() > 0) {
      reactions_.configuration_force = problem().step() / h * constraint_force_ + impulses / h;
    }
    work_ = to.momentum - work_;
    add_reaction(to.position, 0.0, work_, outcome);
  }
};

}  // namespace

std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer,
                                               std::shared_ptr<RootFinder> root_finder) {
  if (system.contact() != nullptr) {
    if (!root_finder) {
      throw InputError("The midpoint rule needs a root finder where a body may touch obstacles.");
    }
    return make_midpoint_contact_stepper(system, std::move(minimizer), std::move(root_finder));
  }
  return std::make_unique<MidpointStepper>(system, std::move(minimizer), std::move(root_finder));
}

}  // namespace tetraction
