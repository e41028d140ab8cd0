#include "tetraction/dynamics/mechanical_system.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {

MechanicalSystem::MechanicalSystem(const TetMesh& mesh, const MaterialModel& material,
                                   double density)
    : mesh_(mesh),
      rest_(mesh_),
      elastic_(rest_, material),
      density_(density),
      mass_(Vector::Zero(mesh_.vertex_count())),
      constraints_(3 * mesh_.vertex_count()) {
  if (!(density > 0.0) || !std::isfinite(density)) {
    throw InputError("The density must be positive and finite (kg/m³), not " +
                     std::to_string(density) + ".");
  }
  for (Index e = 0; e < rest_.element_count(); ++e) {
    for (const Index v : rest_.nodes(e)) mass_[v] += mass_share(e);
  }
}

void MechanicalSystem::set_constraints(DofConstraints constraints) {
  if (constraints.dof_count() != dof_count()) {
    throw InputError("The constraints are for another mesh: the number of vertices differs.");
  }
  if (constraints.free_count() == 0) {
    throw InputError(
        "Every vertex is fixed: there is nothing left to move. Let [[fix]] select fewer vertices.");
  }
  constraints_ = std::move(constraints);
}

void MechanicalSystem::add_force(UserForce force) {
  if (!force.vector.allFinite()) throw InputError("A user force is not finite.");
  for (const Index v : force.vertices) {
    if (v < 0 || v >= vertex_count()) {
      throw InputError("A user force acts on vertex " + std::to_string(v) +
                       ", which the mesh does not have.");
    }
  }
  forces_.push_back(std::move(force));
}

Vector MechanicalSystem::user_force(double time, double h) const {
  Vector f = Vector::Zero(dof_count());
  const double slack = 1e-6 * h;  // time = k h carries round-off
  for (const UserForce& force : forces_) {
    if (time < force.from - slack || time >= force.until - slack) continue;
    for (const Index v : force.vertices) vertex_block(f, v) += force.vector;
  }
  return f;
}

State MechanicalSystem::rest_state() const {
  State state;
  state.position = mesh_.rest_positions();
  state.momentum = Vector::Zero(dof_count());
  state.velocity = Vector::Zero(dof_count());
  return state;
}

void MechanicalSystem::set_velocity(State& state, const Vector& velocity) const {
  state.velocity = velocity;
  constraints_.set_fixed_to_zero(state.velocity);
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(state.momentum, v) = mass_[v] * vertex_block(std::as_const(state.velocity), v);
  }
}

Vector3 MechanicalSystem::center_of_mass(const Vector& q) const {
  Vector3 sum = Vector3::Zero();
  for (Index v = 0; v < vertex_count(); ++v) sum += mass_[v] * vertex_block(q, v);
  return sum / total_mass();
}

Evaluation MechanicalSystem::potential(const Vector& q, double& elastic_energy,
                                       Vector& gradient) const {
  const Evaluation status = elastic_.value_and_gradient(q, elastic_energy, gradient);
  if (status.ok()) environment_.add_gradient(mass_, gradient);
  return status;
}

double MechanicalSystem::kinetic_energy(const Vector& momentum) const {
  return parallel_sum(vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      sum += 0.5 * vertex_block(momentum, v).squaredNorm() / mass_[v];
    }
    return sum;
  });
}

Evaluation MechanicalSystem::energies(const State& state, Energies& energies) const {
  energies.kinetic = kinetic_energy(state.momentum);
  energies.environment = environment_.value(mass_, state.position);
  return elastic_.value(state.position, energies.elastic);
}

Momenta MechanicalSystem::momenta(const State& state) const {
  Momenta m;
  for (Index v = 0; v < vertex_count(); ++v) {
    const Vector3 p = vertex_block(state.momentum, v);
    const Vector3 l = vertex_block(state.position, v).cross(p);
    m.linear += p;
    m.angular += l;
    m.linear_scale += p.norm();
    m.angular_scale += l.norm();
  }
  return m;
}

}  // namespace tetraction
