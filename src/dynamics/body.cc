#include "tetraction/dynamics/body.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "fem/element_blocks.h"
#include "fem/element_fields.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

std::vector<MaterialField> materials_of(const std::vector<BodyRegion>& regions) {
  std::vector<MaterialField> materials;
  materials.reserve(regions.size());
  for (const BodyRegion& region : regions) materials.push_back(region.material);
  return materials;
}

// The materials of the elements.
std::vector<MaterialField> element_materials_of(const std::vector<BodyRegion>& regions,
                                                VolumeRule volume) {
  std::vector<MaterialField> materials = materials_of(regions);
  if (volume == VolumeRule::kElement) return materials;
  for (MaterialField& material : materials) {
    material = NodalVolume::without_volumetric_part(material);
  }
  return materials;
}

}  // namespace

Body::Body(TetMesh mesh, const MaterialField& material, double density)
    : Body(std::move(mesh), {BodyRegion{material, density}}, {}) {}

Body::Body(TetMesh mesh, const std::vector<BodyRegion>& regions,
           const std::vector<int>& region_of_element, VolumeRule volume)
    : mesh_(std::move(mesh)),
      rest_(mesh_),
      elastic_(rest_, element_materials_of(regions, volume), region_of_element),
      density_(rest_.element_count()),
      mass_(Vector::Zero(mesh_.vertex_count())) {
  add_up_masses(regions);
  if (part() != nullptr && (volume == VolumeRule::kNodal || rest_.is_quadratic())) {
    throw InputError(
        "Several processes can hold a body of linear tetrahedra with volumes of elements only: "
        "take mesh.element = \"linear\" and mesh.volume = \"element\", or one process.");
  }
  if (volume == VolumeRule::kNodal) take_nodal_volumes(regions);
}

Body::~Body() = default;

void Body::add_up_masses(const std::vector<BodyRegion>& regions) {
  for (const BodyRegion& region : regions) {
    if (!region.densities.empty() &&
        static_cast<Index>(region.densities.size()) != rest_.element_count()) {
      throw InputError(fmt::format("A region has densities for {} elements, but the mesh has {}.",
                                   region.densities.size(), rest_.element_count()));
    }
  }
  for (Index e = 0; e < rest_.element_count(); ++e) {
    const BodyRegion& own = regions[static_cast<std::size_t>(region(e))];
    density_[e] = own.densities.empty() ? own.density : own.densities[static_cast<std::size_t>(e)];
    if (!(density_[e] > 0.0) || !std::isfinite(density_[e])) {
      throw InputError(
          fmt::format("The density must be positive and finite (kg/m³), not {}.", density_[e]));
    }
    const double mass = element_mass(e);
    int a = 0;
    for (const Index v : rest_.nodes(e)) mass_[v] += mass * rest_.mass_fraction(a++);
  }
  add_shared(part(), mass_, 1);
  inverse_mass_ = mass_.cwiseInverse();
  total_mass_ = mass_.sum();
  if (part() != nullptr) {
    kept_masses_ = mass_.head(owned_vertex_count());
    own_mass_ = kept_masses_.sum();
    total_mass_ = sum_over_parts(part(), own_mass_);
  }
}

void Body::set_masses(const Vector& mass) {
  if (!has_moved_masses()) kept_masses_ = mass_;
  mass_ = mass;
  inverse_mass_ = mass_.cwiseInverse();
  total_mass_ = mass_.sum();
}

void Body::take_nodal_volumes(const std::vector<BodyRegion>& regions) {
  if (rest_.is_quadratic()) {
    throw InputError(
        "mesh.volume = \"nodal\" is for linear tetrahedra, and the mesh has quadratic ones, which "
        "do not need it: leave it out, or take mesh.element = \"linear\".");
  }
  materials_ = materials_of(regions);
  nodal_volume_ = std::make_unique<NodalVolume>(elastic_, materials_);
}

std::vector<Index> Body::elements_of(Index region_index) const {
  std::vector<Index> elements;
  for (Index e = 0; e < rest_.element_count(); ++e) {
    if (region(e) == region_index) elements.push_back(e);
  }
  return elements;
}

void Body::set_material(Index region, const MaterialField& material) {
  const auto index = static_cast<std::size_t>(region);
  if (!nodal_volume_) {
    elastic_.set_material(index, material);
    return;
  }
  elastic_.set_material(index, NodalVolume::without_volumetric_part(material));
  nodal_volume_->set_material(index, material);
  materials_.at(index) = material;
}

LameParameters Body::lame(Index e) const {
  if (!nodal_volume_) return elastic_.lame(e);
  return initial_lame(materials_[static_cast<std::size_t>(region(e))].at(e));
}

EvaluationStatus Body::elastic_energy(const Positions& q, double& energy) const {
  const EvaluationStatus status = elastic_.value(q, energy);
  if (nodal_volume_ && status.ok()) energy += nodal_volume_->energy(q);
  return status;
}

EvaluationStatus Body::elastic_energy_and_gradient(const Positions& q, double& energy,
                                                   Vector& gradient) const {
  if (nodal_volume_) return nodal_volume_->elastic_energy_and_gradient(q, energy, gradient);
  if (part() != nullptr) {
    return BlockAccess::value_and_gradient(elastic_, q, *part(), energy, gradient);
  }
  return elastic_.value_and_gradient(q, energy, gradient);
}

Vector Body::elastic_energies_by_region(const Vector& q) const {
  Vector energies = elastic_.energies_by_material(q);
  if (nodal_volume_) energies += nodal_volume_->energies_by_material(q);
  sum_over_parts(part(), energies.data(), energies.size());
  return energies;
}

void Body::elastic_energy_densities(const Vector& q, Vector& densities) const {
  elastic_.energy_densities(q, densities);
  if (nodal_volume_) nodal_volume_->add_energy_densities(q, densities);
}

Matrix3 Body::first_piola(Index e, const Vector& q) const {
  Matrix3 stress = elastic_.first_piola(e, q);
  if (!nodal_volume_) return stress;
  const Matrix3 f = deformation_gradient(rest_, q, e);
  Matrix3 cofactors;
  for (int k = 0; k < 3; ++k) {
    cofactors.col(k) = Vector3(f.col((k + 1) % 3)).cross(Vector3(f.col((k + 2) % 3)));
  }
  return stress + nodal_volume_->mean_tension(e, q) * cofactors;
}

ElasticPotential::StiffnessSums Body::stiffness_sums(double extra_modulus) const {
  ElasticPotential::StiffnessSums sums = elastic_.stiffness_sums(extra_modulus);
  if (!nodal_volume_) return sums;
  // The root of a sum of squares (a + b)² is at most the sum of the roots of Σ a² and Σ b².
  const auto add = [](double& sum, double other) {
    const double root = std::sqrt(sum) + std::sqrt(other);
    sum = root * root;
  };
  const ElasticPotential::StiffnessSums volume = nodal_volume_->stiffness_sums();
  add(sums.squared, volume.squared);
  add(sums.with_edges, volume.with_edges);
  return sums;
}

State Body::rest_state() const {
  State state;
  state.position = mesh_.rest_positions();
  state.momentum = Vector::Zero(dof_count());
  state.velocity = Vector::Zero(dof_count());
  return state;
}

Vector Body::velocity_of(const Vector& momentum) const {
  Vector velocity;
  velocity_of(momentum, velocity);
  return velocity;
}

void Body::velocity_of(const Vector& momentum, Vector& velocity) const {
  velocity.resize(dof_count());
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(velocity, v) = vertex_block(momentum, v) / mass_[v];
  }
}

Vector Body::momentum_of(const Vector& velocity) const {
  Vector momentum;
  momentum_of(velocity, momentum);
  return momentum;
}

void Body::momentum_of(const Vector& velocity, Vector& momentum) const {
  momentum.resize(dof_count());
  for (Index v = 0; v < vertex_count(); ++v) {
    vertex_block(momentum, v) = mass_[v] * vertex_block(velocity, v);
  }
}

}  // namespace tetraction
