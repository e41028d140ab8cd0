#include "tetraction/dynamics/mechanical_system.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/multipliers.h"
#include "vertex_kernels.h"

namespace tetraction {

namespace {

std::vector<MaterialModel> materials_of(const std::vector<BodyRegion>& regions) {
  std::vector<MaterialModel> materials;
  materials.reserve(regions.size());
  for (const BodyRegion& region : regions) materials.push_back(region.material);
  return materials;
}

// The part of the step from `start` on, of size h, that lies before `time`: 0 to 1.
double part_of_step(double time, double start, double h) {
  const double end = start + h;
  // start = k h carries round-off: a time that is meant to be at an end of the step is taken as it is.
  const double round_off =
      16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  if (std::abs(time - start) <= round_off) return 0.0;
  if (std::abs(time - end) <= round_off) return 1.0;
  return std::clamp((time - start) / h, 0.0, 1.0);
}

}  // namespace

MechanicalSystem::MechanicalSystem(TetMesh mesh, const MaterialModel& material, double density)
    : MechanicalSystem(std::move(mesh), {BodyRegion{material, density}}, {}) {}

MechanicalSystem::MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                                   const std::vector<int>& region_of_element)
    : mesh_(std::move(mesh)),
      rest_(mesh_),
      elastic_(rest_, materials_of(regions), region_of_element),
      viscous_(elastic_),
      mass_(Vector::Zero(mesh_.vertex_count())),
      constraints_(mesh_.vertex_count()) {
  for (const BodyRegion& region : regions) {
    if (!(region.density > 0.0) || !std::isfinite(region.density)) {
      throw InputError("The density must be positive and finite (kg/m³), not " +
                       std::to_string(region.density) + ".");
    }
    densities_.push_back(region.density);
  }
  for (Index e = 0; e < rest_.element_count(); ++e) {
    for (const Index v : rest_.nodes(e)) mass_[v] += mass_share(e);
  }
  inverse_mass_ = mass_.cwiseInverse();
  total_mass_ = mass_.sum();
}

void MechanicalSystem::set_material(Index region, const MaterialModel& material) {
  elastic_.set_material(static_cast<std::size_t>(region), material);
}

Constraints MechanicalSystem::set_constraints(Constraints constraints) {
  if (constraints.coordinates().dof_count() != dof_count()) {
    throw InputError("The constraints are for another mesh: the number of vertices differs.");
  }
  return std::exchange(constraints_, std::move(constraints));
}

void MechanicalSystem::set_damping(const Damping& damping) {
  for (const double value : {damping.drag, damping.mass_damping, damping.viscosity}) {
    if (!(value >= 0.0) || !std::isfinite(value)) {
      throw InputError("Damping must be 0 or more and finite: negative damping makes energy.");
    }
  }
  damping_ = damping;
}

void MechanicalSystem::check(const UserForce& force) const {
  if (!force.vector.allFinite()) throw InputError("A user force is not finite.");
  for (const Index v : force.vertices) {
    if (v < 0 || v >= vertex_count()) {
      throw InputError("A user force acts on vertex " + std::to_string(v) +
                       ", which the mesh does not have.");
    }
  }
}

void MechanicalSystem::add_force(UserForce force) {
  check(force);
  forces_.push_back(std::move(force));
}

void MechanicalSystem::set_force(std::size_t index, UserForce force) {
  check(force);
  forces_.at(index) = std::move(force);
}

void MechanicalSystem::set_forces(std::vector<UserForce> forces) {
  for (const UserForce& force : forces) check(force);
  forces_ = std::move(forces);
}

void MechanicalSystem::user_force(double time, double h, Vector& f) const {
  f.setZero(forces_.empty() ? 0 : dof_count());
  for (const UserForce& force : forces_) {
    const double share = part_of_step(force.until, time, h) - part_of_step(force.from, time, h);
    if (!(share > 0.0)) continue;
    for (const Index v : force.vertices) vertex_block(f, v) += share * force.vector;
  }
}

State MechanicalSystem::rest_state() const {
  State state;
  state.position = mesh_.rest_positions();
  state.momentum = Vector::Zero(dof_count());
  state.velocity = Vector::Zero(dof_count());
  return state;
}

void MechanicalSystem::add_drag_force(const Vector& v, Vector& force) const {
  if (damping_.drag == 0.0 && damping_.mass_damping == 0.0) return;
  for (Index a = 0; a < vertex_count(); ++a) {
    vertex_block(force, a) -=
        (damping_.drag + damping_.mass_damping * mass_[a]) * vertex_block(v, a);
  }
}

void MechanicalSystem::add_viscous_force(const Vector& q, const Vector& v, Vector& force) const {
  if (damping_.viscosity > 0.0) viscous_.add_force(damping_.viscosity, q, v, force);
}

Vector MechanicalSystem::velocity_of(const Vector& momentum) const {
  Vector velocity;
  velocity_of(momentum, velocity);
  return velocity;
}

void MechanicalSystem::velocity_of(const Vector& momentum, Vector& velocity) const {
  velocity.resize(dof_count());
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(velocity, v) = vertex_block(momentum, v) / mass_[v];
  }
}

Vector MechanicalSystem::momentum_of(const Vector& velocity) const {
  Vector momentum;
  momentum_of(velocity, momentum);
  return momentum;
}

void MechanicalSystem::momentum_of(const Vector& velocity, Vector& momentum) const {
  momentum.resize(dof_count());
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(momentum, v) = mass_[v] * vertex_block(velocity, v);
  }
}

void MechanicalSystem::set_velocity(State& state, const Vector& velocity) const {
  state.momentum = momentum_of(velocity);
  project_to_constraints(constraints_, mass_, state.position, state.time, state.momentum);
  state.velocity = velocity_of(state.momentum);
}

Vector3 MechanicalSystem::center_of_mass(const Vector& q) const {
  return sums(q, q).first_moment / total_mass();
}

VertexSums MechanicalSystem::sums(const Vector& q, const Vector& p) const {
  constexpr Index kRange = 2048;
  const Index ranges = (vertex_count() + kRange - 1) / kRange;
  std::vector<VertexSums> parts(static_cast<std::size_t>(ranges));
  parallel_for(ranges, 1, [&](Index begin, Index end) {
    for (Index r = begin; r < end; ++r) {
      parts[static_cast<std::size_t>(r)] =
          vertex_sums(r * kRange, std::min(vertex_count(), (r + 1) * kRange), mass_.data(),
                      inverse_mass_.data(), q.data(), p.data());
    }
  });
  VertexSums total;
  for (const VertexSums& part : parts) total += part;
  return total;
}

Evaluation MechanicalSystem::potential(const Vector& q, double& elastic_energy,
                                       Vector& gradient) const {
  const Evaluation status = elastic_.value_and_gradient(q, elastic_energy, gradient);
  if (status.ok()) environment_.add_gradient(mass_, q, gradient);
  return status;
}

double MechanicalSystem::kinetic_energy(const Vector& momentum) const {
  return 0.5 * sums(momentum, momentum).twice_kinetic;
}

Vector MechanicalSystem::kinetic_energies_by_region(const Vector& momentum) const {
  Vector energies = Vector::Zero(region_count());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    for (const Index v : rest_.nodes(e)) {
      energies[region(e)] +=
          0.5 * mass_share(e) * (vertex_block(momentum, v) / mass_[v]).squaredNorm();
    }
  }
  return energies;
}

Evaluation MechanicalSystem::energies(const State& state, Energies& energies) const {
  Momenta ignored;
  vertex_books(state, energies, ignored);
  return elastic_.value(state.position, energies.elastic);
}

Momenta MechanicalSystem::momenta(const State& state) const {
  const VertexSums total = sums(state.position, state.momentum);
  return {total.linear, total.angular, total.linear_scale, total.angular_scale};
}

void MechanicalSystem::vertex_books(const State& state, Energies& energies,
                                    Momenta& momenta) const {
  const VertexSums total = sums(state.position, state.momentum);
  momenta = {total.linear, total.angular, total.linear_scale, total.angular_scale};
  energies.kinetic = 0.5 * total.twice_kinetic;
  // A difference, as minus zero would be written where there is no energy.
  energies.environment = environment_.is_uniform()
                             ? 0.0 - environment_.acceleration().dot(total.first_moment)
                             : environment_.value(mass_, state.position);
}

}  // namespace tetraction
