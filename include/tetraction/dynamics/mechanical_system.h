// The body and everything that acts on it: what the integrators step.
#pragma once

#include <limits>
#include <vector>

#include "tetraction/dynamics/environment.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/fem/dof_constraints.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// A force on each of some vertices, constant over every step that starts in [from, until).
struct UserForce {
  std::vector<Index> vertices;
  Vector3 vector = Vector3::Zero();                        ///< N, on every vertex of the list
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
};

/// Energies of a state, J.
struct Energies {
  double kinetic = 0.0;      ///< T = ½ pᵀM⁻¹p
  double elastic = 0.0;      ///< Σ V Ψ
  double environment = 0.0;  ///< potential of the environment
  double total() const { return kinetic + elastic + environment; }
};

/// Linear and angular momentum about the origin, with the sums of magnitudes that drifts are
/// measured against.
struct Momenta {
  Vector3 linear = Vector3::Zero();   ///< Σ p, kg m/s
  Vector3 angular = Vector3::Zero();  ///< Σ q × p, kg m²/s
  double linear_scale = 0.0;          ///< Σ |p|
  double angular_scale = 0.0;         ///< Σ |q × p|
};

/// Mesh, rest state, material, lumped mass, fixed DOFs and loads of one body.
///
/// Lumped mass: each tetrahedron gives ρ₀V/4 to each of its vertices. Not for: time stepping
/// (Stepper), bookkeeping (EnergyBooks).
class MechanicalSystem {
 public:
  /// Copies the mesh. Throws InputError if density is not positive and finite.
  MechanicalSystem(const TetMesh& mesh, const MaterialModel& material, double density);
  MechanicalSystem(const MechanicalSystem&) = delete;
  MechanicalSystem& operator=(const MechanicalSystem&) = delete;

  const TetMesh& mesh() const { return mesh_; }
  const RestState& rest() const { return rest_; }
  const ElasticPotential& elastic() const { return elastic_; }
  double density() const { return density_; }
  /// Per vertex, kg.
  const Vector& mass() const { return mass_; }
  double total_mass() const { return mass_.sum(); }
  /// The share of element e in the mass of each of its vertices: ρ₀V/4, kg.
  double mass_share(Index e) const { return density_ * rest_.volume(e) / RestState::Shape::kNodes; }
  Index vertex_count() const { return mesh_.vertex_count(); }
  Index dof_count() const { return 3 * vertex_count(); }

  /// Which DOFs are held. Throws InputError if that leaves none free.
  void set_constraints(DofConstraints constraints);
  const DofConstraints& constraints() const { return constraints_; }
  void set_environment(const Environment& environment) { environment_ = environment; }
  const Environment& environment() const { return environment_; }
  void add_force(UserForce force);
  /// f of the step of size h that starts at `time`: 3 per vertex, N.
  /// A start within 1e-6 h of `from` or `until` counts as being there.
  Vector user_force(double time, double h) const;

  /// At rest in the reference configuration, with fixed DOFs where they are.
  State rest_state() const;
  /// p = Mv, with zero for fixed DOFs.
  void set_velocity(State& state, const Vector& velocity) const;
  /// Mass-weighted mean of positions, m.
  Vector3 center_of_mass(const Vector& q) const;

  /// value = elastic energy, gradient = ∇W of elastic and environment energy together.
  Evaluation potential(const Vector& q, double& elastic_energy, Vector& gradient) const;
  double kinetic_energy(const Vector& momentum) const;
  /// Fails where the elastic energy is not defined.
  Evaluation energies(const State& state, Energies& energies) const;
  Momenta momenta(const State& state) const;

 private:
  TetMesh mesh_;
  RestState rest_;
  ElasticPotential elastic_;
  double density_;
  Vector mass_;
  DofConstraints constraints_;
  Environment environment_;
  std::vector<UserForce> forces_;
};

}  // namespace tetraction
