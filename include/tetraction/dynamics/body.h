// A body of tetrahedra at rest: its mesh, its materials, its masses and its elasticity.
#pragma once

#include <memory>
#include <vector>

#include "tetraction/dynamics/nodal_volume/volume_rule.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/fem/elastic_potential.h"

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

/// Mesh, rest state, materials, lumped mass and elastic energy of one body.
///
/// Each tetrahedron adds ρ₀V/4 to the lumped mass of each of its vertices. MechanicalSystem adds what acts on the
/// body; sums over it are in dynamics/body_sums.h.
class Body {
 public:
  /// The whole body has one material. The body keeps the mesh, as a copy or, with std::move(),
  /// the caller's own vectors. The arrays of a view_mesh() are not copied and must live longer than
  /// the body. Throws InputError if a density is not positive and finite.
  Body(TetMesh mesh, const MaterialField& material, double density);
  /// Element e belongs to regions[region_of_element[e]]. With VolumeRule::kNodal it throws InputError
  /// for a material without a volumetric part, too.
  Body(TetMesh mesh, const std::vector<BodyRegion>& regions,
       const std::vector<int>& region_of_element, VolumeRule volume = VolumeRule::kElement);
  ~Body();
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

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
  /// The mass of the own vertices of a part, kg; of a whole mesh, that of all.
  double own_mass() const { return part() != nullptr ? own_mass_ : total_mass_; }
  /// The lumped masses of the own vertices of a part, kg; of a whole mesh, those of all.
  const Vector& own_masses() const { return part() != nullptr ? kept_masses_ : mass_; }
  /// The mass of element e, kg.
  double element_mass(Index e) const { return density(e) * rest_.volume(e); }
  /// The share of element e in the mass of its node a, kg (RestState::mass_fraction()). After set_masses() it is larger
  /// or smaller as the mass of the node is.
  double mass_share(Index e, int a) const {
    const double share = element_mass(e) * rest_.mass_fraction(a);
    if (!has_moved_masses()) return share;
    const Index v = rest_.nodes(e)[static_cast<std::size_t>(a)];
    return share * (mass_[v] / kept_masses_[v]);
  }
  /// Replaces the lumped masses of the vertices, kg, all above zero, by others with the same sum. Call it before there
  /// are constraints. Not for a body in parts.
  void set_masses(const Vector& mass);
  /// Whether set_masses() has replaced the lumped masses.
  bool has_moved_masses() const { return part() == nullptr && kept_masses_.size() > 0; }
  /// The lumped masses of the vertices without set_masses(), kg.
  const Vector& lumped_masses() const { return has_moved_masses() ? kept_masses_ : mass_; }
  Index vertex_count() const { return mesh_.vertex_count(); }
  /// The whole that the mesh is a part of, where several processes hold the body together (mesh/mesh_part.h);
  /// null otherwise. Masses and assembled fields are then those of the whole body at each vertex of the
  /// part. Sums over the body are those of the whole body where a comment does not say otherwise.
  const MeshPart* part() const { return mesh_.part.get(); }
  /// Sums over vertices take the vertices below this number: all, or the own ones of a part.
  Index owned_vertex_count() const {
    return mesh_.part ? mesh_.part->owned_vertices : mesh_.vertex_count();
  }
  Index dof_count() const { return 3 * vertex_count(); }

  /// v = M⁻¹p.
  Vector velocity_of(const Vector& momentum) const;
  void velocity_of(const Vector& momentum, Vector& velocity) const;
  /// p = Mv.
  Vector momentum_of(const Vector& velocity) const;
  void momentum_of(const Vector& velocity, Vector& momentum) const;

  /// The state at rest in the reference configuration.
  State rest_state() const;

 private:
  void add_up_masses(const std::vector<BodyRegion>& regions);
  void take_nodal_volumes(const std::vector<BodyRegion>& regions);

  TetMesh mesh_;
  RestState rest_;
  ElasticPotential elastic_;
  std::vector<MaterialField> materials_;  // whole; empty with VolumeRule::kElement
  std::unique_ptr<NodalVolume> nodal_volume_;
  Vector density_;  // per element
  Vector mass_;
  Vector inverse_mass_;
  Vector
      kept_masses_;  // of a part, those of its own vertices; otherwise those before set_masses(), or empty
  double total_mass_ = 0.0;
  double own_mass_ = 0.0;  // of a part
};

}  // namespace tetraction
