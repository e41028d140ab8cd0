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
    // The force of a distance on a prescribed vertex is no part of what moves it: the distance takes
    // as much work there as it gives at its other end, and what moves the vertex has to make up for it.
    Vector support = reaction_;
    if (configuration_force_.size() > 0) support -= constraints.vertex_forces(configuration_force_);
    constraints.for_each_prescribed_way(from.position, to.time, [&](Index v, const Vector3& way) {
      work += vertex_block(support, v).dot(way);
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
