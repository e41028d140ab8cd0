#include "tetraction/dynamics/stepper.h"

#include <Eigen/Geometry>

namespace tetraction {

Stepper::Stepper(const MechanicalSystem& system)
    : system_(system), reaction_(Vector::Zero(system.dof_count())) {}

void Stepper::set_reaction(const Vector& gradient, const Vector& user_force) {
  reaction_.setZero(system_.dof_count());
  for (const Index i : system_.constraints().fixed_dofs()) {
    reaction_[i] = gradient[i] - user_force[i];
  }
}

void Stepper::add_impulse(const Vector& x, const Vector& user_force, const Vector& reaction,
                          double weighted_h, StepOutcome& outcome) const {
  const Vector3& a = system_.environment().acceleration();
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const Vector3 impulse = weighted_h * (vertex_block(user_force, v) + vertex_block(reaction, v) +
                                          system_.mass()[v] * a);
    outcome.linear_impulse += impulse;
    outcome.angular_impulse += vertex_block(x, v).cross(impulse);
  }
}

}  // namespace tetraction
