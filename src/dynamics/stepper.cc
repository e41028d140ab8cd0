#include "tetraction/dynamics/stepper.h"

#include <Eigen/Geometry>

namespace tetraction {

Stepper::Stepper(const MechanicalSystem& system)
    : system_(system), reaction_(Vector::Zero(system.dof_count())) {}

void Stepper::add_impulse(const Vector& x, const Vector& force, double dt,
                          StepOutcome& outcome) const {
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const Vector3 impulse = dt * vertex_block(force, v);
    outcome.linear_impulse += impulse;
    outcome.angular_impulse += vertex_block(x, v).cross(impulse);
  }
}

void Stepper::add_reaction(const Vector& x, const Vector& impulse, StepOutcome& outcome) {
  reaction_ += impulse;
  add_impulse(x, impulse, 1.0, outcome);
}

double Stepper::constraint_work(const State& from, const State& to) const {
  const Constraints& constraints = system_.constraints();
  double work = 0.0;
  if (constraints.moving()) {
    // A reaction is the force of the support and that of distances at the vertex. A distance takes as
    // much work at one end as it gives at the other, so that only the support's work enters the body.
    Vector passed_on;
    if (configuration_force_.size() > 0) {
      passed_on = constraints.vertex_forces(configuration_force_);
    }
    constraints.for_each_prescribed_way(from.position, to.time, [&](Index v, const Vector3& way) {
      work += vertex_block(reaction_, v).dot(way);
      if (passed_on.size() > 0) work -= vertex_block(passed_on, v).dot(way);
    });
  }
  if (constraints.has_springs()) {
    // What a moving target puts into its spring, less what stays in it.
    work += constraints.spring_energy(from.position, from.time) -
            constraints.spring_energy(to.position, to.time);
    work += constraints.spring_work(from.position, from.time, to.position, to.time);
  }
  return work;
}

}  // namespace tetraction
