// The body and everything that acts on it: what the integrators step.
#pragma once

#include <limits>
#include <vector>

#include "tetraction/dynamics/constraints.h"
#include "tetraction/dynamics/damping.h"
#include "tetraction/dynamics/environment.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

struct VertexSums;

/// A force on each of some vertices, constant from `from` until `until`. Both may lie inside a step.
struct UserForce {
  std::vector<Index> vertices;
  Vector3 vector = Vector3::Zero();                        ///< N, on every vertex of the list
  double from = 0.0;                                       ///< s
  double until = std::numeric_limits<double>::infinity();  ///< s
};

/// What a part of the body is made of.
struct BodyRegion {
  MaterialModel material;
  double density = 1000.0;  ///< ρ₀, kg/m³
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

/// Mesh, rest state, materials, lumped mass, constraints, damping and loads of one body.
///
/// Lumped mass: each tetrahedron gives ρ₀V/4 to each of its vertices. Not for: time stepping
/// (Stepper), bookkeeping (Books).
class MechanicalSystem {
 public:
  /// One material everywhere. Keeps the mesh: a copy, or with std::move() the caller's own vectors.
  /// Of a view_mesh() nothing is copied: the arrays behind it must live longer than the system.
  /// Throws InputError if density is not positive and finite.
  MechanicalSystem(TetMesh mesh, const MaterialModel& material, double density);
  /// Element e is of regions[region_of_element[e]].
  MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                   const std::vector<int>& region_of_element);
  MechanicalSystem(const MechanicalSystem&) = delete;
  MechanicalSystem& operator=(const MechanicalSystem&) = delete;

  const TetMesh& mesh() const { return mesh_; }
  const RestState& rest() const { return rest_; }
  const ElasticPotential& elastic() const { return elastic_; }
  Index region_count() const { return static_cast<Index>(densities_.size()); }
  /// The region of element e.
  int region(Index e) const { return elastic_.material_index(e); }
  double density(Index region = 0) const { return densities_[static_cast<std::size_t>(region)]; }
  /// Exchanges the material of a region; its density stays.
  void set_material(Index region, const MaterialModel& material);
  /// Per vertex, kg.
  const Vector& mass() const { return mass_; }
  const Vector& inverse_mass() const { return inverse_mass_; }
  double total_mass() const { return total_mass_; }
  /// The share of element e in the mass of each of its vertices: ρ₀V/4, kg.
  double mass_share(Index e) const {
    return density(region(e)) * rest_.volume(e) / RestState::Shape::kNodes;
  }
  Index vertex_count() const { return mesh_.vertex_count(); }
  Index dof_count() const { return 3 * vertex_count(); }

  /// What holds and guides the body. Returns what did before.
  Constraints set_constraints(Constraints constraints);
  const Constraints& constraints() const { return constraints_; }
  const FreeCoordinates& coordinates() const { return constraints_.coordinates(); }
  void set_environment(const Environment& environment) { environment_ = environment; }
  const Environment& environment() const { return environment_; }
  /// Throws InputError for numbers that are negative or not finite.
  void set_damping(const Damping& damping);
  const Damping& damping() const { return damping_; }
  /// Throws InputError for a force that is not finite or a vertex that is not there.
  void add_force(UserForce force);
  /// Exchanges the force added as number `index`.
  void set_force(std::size_t index, UserForce force);
  const std::vector<UserForce>& forces() const { return forces_; }
  /// Exchanges all of them.
  void set_forces(std::vector<UserForce> forces);
  /// f of the step of size h that starts at `time`: the mean over the step, so that h f is the impulse
  /// ∫ f dt of every force. 3 per vertex, N; empty if there are no forces at all.
  void user_force(double time, double h, Vector& f) const;
  /// force += drag and mass damping at velocities v, which take momentum away (3 per vertex, N).
  void add_drag_force(const Vector& v, Vector& force) const;
  /// force += the viscous forces at positions q and velocities v, which do not.
  void add_viscous_force(const Vector& q, const Vector& v, Vector& force) const;
  /// v = M⁻¹p.
  Vector velocity_of(const Vector& momentum) const;
  void velocity_of(const Vector& momentum, Vector& velocity) const;
  /// p = Mv.
  Vector momentum_of(const Vector& velocity) const;
  void momentum_of(const Vector& velocity, Vector& momentum) const;

  /// At rest in the reference configuration.
  State rest_state() const;
  /// p = Mv, less what the constraints do not allow; prescribed components move as prescribed.
  void set_velocity(State& state, const Vector& velocity) const;
  /// Mass-weighted mean of positions, m.
  Vector3 center_of_mass(const Vector& q) const;

  /// value = elastic energy, gradient = ∇W of elastic and environment energy together.
  Evaluation potential(const Vector& q, double& elastic_energy, Vector& gradient) const;
  double kinetic_energy(const Vector& momentum) const;
  /// ½ Σ m_r|p/m|² of each region, with m_r the region's share in the mass of a vertex, J.
  Vector kinetic_energies_by_region(const Vector& momentum) const;
  /// Fails where the elastic energy is not defined.
  Evaluation energies(const State& state, Energies& energies) const;
  Momenta momenta(const State& state) const;
  /// Kinetic and environment energy and the momenta in one pass over the vertices; the elastic
  /// energy is left alone.
  void vertex_books(const State& state, Energies& energies, Momenta& momenta) const;

 private:
  void check(const UserForce& force) const;
  VertexSums sums(const Vector& q, const Vector& p) const;

  TetMesh mesh_;
  RestState rest_;
  ElasticPotential elastic_;
  ViscousPotential viscous_;
  std::vector<double> densities_;
  Vector mass_;
  Vector inverse_mass_;
  double total_mass_ = 0.0;
  Constraints constraints_;
  Environment environment_;
  Damping damping_;
  std::vector<UserForce> forces_;
};

}  // namespace tetraction
