// The body and everything that acts on it. Integrators advance such a system in time.
#pragma once

#include <memory>
#include <vector>

#include "tetraction/dynamics/constraints/constraints.h"
#include "tetraction/dynamics/energies.h"
#include "tetraction/dynamics/nodal_volume/volume_rule.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/dynamics/terms/damping.h"
#include "tetraction/dynamics/terms/environment.h"
#include "tetraction/dynamics/terms/external_forces.h"
#include "tetraction/dynamics/terms/force_term.h"
#include "tetraction/dynamics/terms/surface_pressure.h"
#include "tetraction/dynamics/terms/vertex_damping.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/viscous_potential.h"

namespace tetraction {

/// The material and the density of a part of the body.
struct BodyRegion {
  MaterialField material;
  double density = 1000.0;  ///< ρ₀, kg/m³
  /// ρ₀ of every element of the mesh, kg/m³; those of other regions are ignored. If there are any,
  /// they hold instead of `density`.
  std::vector<double> densities{};
};

class NodalVolume;

/// Linear and angular momentum about the origin, and the sums of magnitudes to which drifts are
/// relative.
struct Momenta {
  Vector3 linear = Vector3::Zero();   ///< Σ p, kg m/s
  Vector3 angular = Vector3::Zero();  ///< Σ q × p, kg m²/s
  double linear_scale = 0.0;          ///< Σ |p|
  double angular_scale = 0.0;         ///< Σ |q × p|
};

/// Mesh, rest state, materials, lumped mass, constraints, damping and loads of one body.
///
/// Each tetrahedron adds ρ₀V/4 to the lumped mass of each of its vertices. Time stepping is in
/// Stepper, the balance of energy and momentum in Balance.
class MechanicalSystem {
 public:
  /// The whole body has one material. The system keeps the mesh, as a copy or, with std::move(),
  /// the caller's own vectors. The arrays of a view_mesh() are not copied and must live longer than
  /// the system. Throws InputError if a density is not positive and finite.
  MechanicalSystem(TetMesh mesh, const MaterialField& material, double density);
  /// Element e belongs to regions[region_of_element[e]]. With VolumeRule::kNodal it throws InputError
  /// for a material without a volumetric part, too.
  MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                   const std::vector<int>& region_of_element,
                   VolumeRule volume = VolumeRule::kElement);
  ~MechanicalSystem();
  MechanicalSystem(const MechanicalSystem&) = delete;
  MechanicalSystem& operator=(const MechanicalSystem&) = delete;

  const TetMesh& mesh() const { return mesh_; }
  const RestState& rest() const { return rest_; }
  /// The part of the elastic energy that is a sum over elements: all of it, or with
  /// VolumeRule::kNodal that of materials without their volumetric parts.
  const ElasticPotential& elastic() const { return elastic_; }
  /// The other part of the elastic energy; null with VolumeRule::kElement.
  const NodalVolume* nodal_volume() const { return nodal_volume_.get(); }
  /// The whole materials of the regions.
  const std::vector<MaterialField>& materials() const {
    return nodal_volume_ ? materials_ : elastic_.materials();
  }
  /// The small-strain parameters of element e, Pa.
  LameParameters lame(Index e) const;
  /// energy = the whole elastic energy at q, J; of a part, that of its own tetrahedra. Fails where it is
  /// not defined.
  EvaluationStatus elastic_energy(const Positions& q, double& energy) const;
  /// energy = the same, and gradient = the gradient of the whole elastic energy (3 per vertex, N).
  EvaluationStatus elastic_energy_and_gradient(const Positions& q, double& energy,
                                               Vector& gradient) const;
  /// The elastic energy of every region, J. It must be defined at q.
  Vector elastic_energies_by_region(const Vector& q) const;
  /// The energy density at the first quadrature point of every element, J/m³. With VolumeRule::kNodal
  /// the mean of its nodes is part of it, so that the sum of densities times volumes is the energy.
  void elastic_energy_densities(const Vector& q, Vector& densities) const;
  /// P at the first quadrature point of element e, Pa, with the mean of U' of its nodes. The elastic
  /// energy must be defined at q.
  Matrix3 first_piola(Index e, const Vector& q) const;
  /// ElasticPotential::stiffness_sums() of the whole materials.
  ElasticPotential::StiffnessSums stiffness_sums(double extra_modulus) const;
  Index region_count() const { return static_cast<Index>(elastic_.materials().size()); }
  /// The region of element e.
  int region(Index e) const { return elastic_.material_index(e); }
  /// The elements of a region, ascending.
  std::vector<Index> elements_of(Index region) const;
  /// ρ₀ of element e, kg/m³.
  double density(Index e) const { return density_[e]; }
  /// Replaces the material of a region. Its density stays. Throws InputError as the constructor does;
  /// then nothing has changed.
  void set_material(Index region, const MaterialField& material);
  /// The lumped masses, one per vertex, kg.
  const Vector& mass() const { return mass_; }
  const Vector& inverse_mass() const { return inverse_mass_; }
  double total_mass() const { return total_mass_; }
  /// The mass of the own vertices of a part, kg, and Σ m q over them; of a whole mesh, those of all.
  double own_mass() const { return part() != nullptr ? own_mass_ : total_mass_; }
  Vector3 own_first_moment(const Vector& q) const;
  /// The mass of element e, kg.
  double element_mass(Index e) const { return density(e) * rest_.volume(e); }
  /// The share of element e in the mass of its node a, kg (RestState::mass_fraction()).
  double mass_share(Index e, int a) const { return element_mass(e) * rest_.mass_fraction(a); }
  Index vertex_count() const { return mesh_.vertex_count(); }
  /// What the mesh is a part of, where several processes hold the body together (mesh/mesh_part.h);
  /// null otherwise. Masses and assembled fields are then those of the whole body at each vertex of the
  /// part. Sums over the body are those of the whole body where a comment does not say otherwise.
  const MeshPart* part() const { return mesh_.part.get(); }
  /// Sums over vertices take the vertices below this number: all, or the own ones of a part.
  Index owned_vertex_count() const {
    return mesh_.part ? mesh_.part->owned_vertices : mesh_.vertex_count();
  }
  Index dof_count() const { return 3 * vertex_count(); }

  /// Replaces all constraints of the body. Returns the former ones.
  Constraints set_constraints(Constraints constraints);
  const Constraints& constraints() const { return constraints_; }
  const FreeCoordinates& coordinates() const { return constraints_.coordinates(); }
  void set_environment(const Environment& environment) { environment_ = environment; }
  const Environment& environment() const { return environment_; }
  /// Throws InputError for numbers that are negative or not finite.
  void set_damping(const Damping& damping);
  const Damping& damping() const { return damping_; }
  /// Throws InputError for a force that is not finite or a vertex that does not exist.
  void add_force(ExternalForce force);
  /// Replaces force number `index`, counted from 0 in the order of their addition.
  void set_force(std::size_t index, ExternalForce force);
  const std::vector<ExternalForce>& forces() const { return external_forces_.list(); }
  /// Replaces all forces.
  void set_forces(std::vector<ExternalForce> forces);
  /// Replaces all pressures. Throws InputError for a pressure that is not finite, a vertex that does
  /// not exist, or a pressure without triangles.
  void set_pressures(std::vector<PressureLoad> pressures);
  const std::vector<PressureLoad>& pressures() const { return pressure_.list(); }

  /// Adds a force term of the caller's own. Steppers and solvers that were made before do not know
  /// it. Throws InputError for a null pointer, for a name that is not made of lower-case letters,
  /// digits and underscores, or that another term or energy has, and for a potential without an
  /// account.
  void add_force_term(std::shared_ptr<const ForceTerm> term);
  /// Everything that acts on the body besides elasticity and viscosity: environment, damping of
  /// single vertices, penalty springs, external forces, pressure, and the terms that were added, in
  /// this order.
  const std::vector<const ForceTerm*>& force_terms() const { return terms_; }
  /// Where force terms are evaluated, at an instant. It refers to `position`.
  ForcePoint force_point(const Vector& position, double time) const {
    return {force_masses(), position, time};
  }
  /// The same for forces that act in a step.
  ForcePoint force_point(const Vector& position, double time,
                         const std::optional<TimeSpan>& step) const {
    return {force_masses(), position, time, step};
  }
  /// Where energies of terms are evaluated, at an instant. Its masses are those of the own vertices only.
  /// Energies, changes of energy and driven work at such points are those of the own part.
  ForcePoint energy_point(const Vector& position, double time) const {
    return {part() != nullptr ? owned_mass_ : force_masses(), position, time};
  }
  /// |Tᵀ f|₂ over the free coordinates of the whole body (FreeCoordinates::restricted_norm()).
  double restricted_norm(const Vector& full) const;
  /// Lets forces per mass, such as gravity, act with consistent weights
  /// (dynamics/consistent_mass.h) instead of the lumped masses, for statics. External forces that
  /// were added before stay as they are.
  void use_consistent_weights();
  /// ∫ N_a dV over element e for each of its nodes a, m³: the weights with which a force per volume
  /// acts on them. They are the element's volume times RestState::mass_fraction(), or the consistent
  /// weights after use_consistent_weights().
  Vector element_weights(Index e) const;
  /// f ← the sum of the loads of all terms at a point (3 per vertex, N): their mean over a step, so
  /// that h f is the impulse ∫ f dt, or their values at an instant. It is empty if no term has a load.
  void external_force(const ForcePoint& at, Vector& f) const;
  /// f ← all forces of the user's on the vertices: the loads, and the forces of potentials that count
  /// as external work (pressure).
  void applied_force(const ForcePoint& at, Vector& f) const;
  /// The same, as the means over the step of size h that starts at `time`, with the positions `q`
  /// where forces depend on positions.
  void external_force(const Vector& q, double time, double h, Vector& f) const {
    external_force(force_point(q, time, TimeSpan{time, time + h}), f);
  }
  void applied_force(const Vector& q, double time, double h, Vector& f) const {
    applied_force(force_point(q, time, TimeSpan{time, time + h}), f);
  }
  /// Whether a load depends on positions.
  bool has_load_of_position() const;
  /// force −= ∂D/∂v of all terms at velocities v (3 per vertex, N). Viscosity is not included.
  void add_damping_force(const Vector& q, double time, const Vector& v, Vector& force) const;
  /// Whether a term or viscosity dissipates energy of a moving body.
  bool is_dissipative() const;
  /// Returns the first term whose potential is not defined at q, or null if all are defined. `vertex` is
  /// the first vertex at which it is not defined, or −1 if the energy of the term is not finite. Of a
  /// part, only its own vertices count.
  const ForceTerm* undefined_term(const Vector& q, double time, Index& vertex) const;

  /// force += the forces of viscosity at positions q and velocities v (3 per vertex, N).
  void add_viscous_force(const Vector& q, const Vector& v, Vector& force) const;
  /// v = M⁻¹p.
  Vector velocity_of(const Vector& momentum) const;
  void velocity_of(const Vector& momentum, Vector& velocity) const;
  /// p = Mv.
  Vector momentum_of(const Vector& velocity) const;
  void momentum_of(const Vector& velocity, Vector& momentum) const;

  /// The state at rest in the reference configuration.
  State rest_state() const;
  /// Sets p = Mv, projected to what the constraints allow. Prescribed components move as
  /// prescribed.
  void set_velocity(State& state, const Vector& velocity) const;
  /// Mass-weighted mean of positions, m.
  Vector3 center_of_mass(const Vector& q) const;

  double kinetic_energy(const Vector& momentum) const;
  /// ½ Σ m_r|p/m|² of each region, with m_r the region's share in the mass of a vertex, J.
  Vector kinetic_energies_by_region(const Vector& momentum) const;
  /// Fails where the elastic energy is not defined.
  EvaluationStatus energies(const State& state, Energies& energies) const;
  Momenta momenta(const State& state) const;
  /// Kinetic energy, the energies of all terms and the momenta; the elastic energy is left alone. `springs` ←
  /// the sum of the magnitudes of the energies of terms that stand for constraints, J. `sums`: what
  /// the balance_shares() of all parts add up to, if that is known already.
  void vertex_balance(const State& state, Energies& energies, Momenta& momenta, double& springs,
                      const std::vector<double>& sums = {}) const;
  /// The share of this part of the body in the numbers of vertex_balance(), for a sum over all parts.
  std::vector<double> balance_shares(const State& state) const;
  /// The number of these numbers, the same in all parts.
  std::size_t balance_share_count() const;

 private:
  double spring_energies(const State& state) const;
  const Vector& force_masses() const { return weights_.size() > 0 ? weights_ : mass_; }
  void check(const ExternalForce& force) const;
  void list_terms();

  TetMesh mesh_;
  RestState rest_;
  ElasticPotential elastic_;
  std::vector<MaterialField> materials_;  // whole; empty with VolumeRule::kElement
  std::unique_ptr<NodalVolume> nodal_volume_;
  ViscousPotential viscous_;
  Vector density_;  // per element
  Vector mass_;
  Vector inverse_mass_;
  Vector weights_;     // in place of mass_ for forces; empty if they are the same
  Vector owned_mass_;  // of the own vertices of a part; empty for a whole mesh
  double total_mass_ = 0.0;
  double own_mass_ = 0.0;  // of a part
  Constraints constraints_;
  Environment environment_;
  Damping damping_;
  VertexDamping vertex_damping_;
  ExternalForces external_forces_;
  SurfacePressure pressure_;
  std::vector<std::shared_ptr<const ForceTerm>> added_terms_;
  std::vector<const ForceTerm*> terms_;
};

}  // namespace tetraction
