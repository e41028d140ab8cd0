#include "tetraction/dynamics/mechanical_system.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "dynamics/terms/vertex_kernels.h"
#include "fem/element_blocks.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/dynamics/constraints/multipliers.h"
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

// What vertices may do, where those count as free that supports move, or hold elsewhere than at rest.
FreeCoordinates coordinates_at_rest(const Constraints& constraints, const Vector& rest) {
  const FreeCoordinates& all = constraints.coordinates();
  Vector held = rest;
  constraints.prescribe(0.0, held);
  std::set<Index> moving;
  for (const PrescribedVertices& list : constraints.list().held) {
    if (list.penalty > 0.0 || list.motion.at_rest()) continue;
    moving.insert(list.vertices.begin(), list.vertices.end());
  }
  std::map<Index, VertexFreedom> freedoms;
  for (Index v = 0; v < all.vertex_count(); ++v) {
    if (all.is_free(v) || all.set_of(v) >= 0 || moving.contains(v)) continue;
    const FreeCoordinates::VertexMap map = all.map(v);
    if (map.count > 0 && vertex_block(held, v) != vertex_block(rest, v)) continue;
    VertexFreedom& freedom = freedoms[v];
    freedom.count = map.count;
    freedom.basis.leftCols(map.count) = map.columns;
  }
  return {all.vertex_count(), std::move(freedoms), all.sets()};
}

bool is_column_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

// The sums over the own vertices, in an order that does not depend on the number of threads.
VertexSums own_sums(const MechanicalSystem& system, const Vector& q, const Vector& p) {
  constexpr Index kRange = 2048;
  const Index count = system.owned_vertex_count();
  const Index ranges = (count + kRange - 1) / kRange;
  std::vector<VertexSums> parts(static_cast<std::size_t>(ranges));
  parallel_for(ranges, 1, [&](Index begin, Index end) {
    for (Index r = begin; r < end; ++r) {
      parts[static_cast<std::size_t>(r)] =
          vertex_sums(r * kRange, std::min(count, (r + 1) * kRange), system.mass().data(),
                      system.inverse_mass().data(), q.data(), p.data());
    }
  });
  VertexSums total;
  for (const VertexSums& part : parts) total += part;
  return total;
}

VertexSums sums(const MechanicalSystem& system, const Vector& q, const Vector& p) {
  VertexSums total = own_sums(system, q, p);
  if (system.part() == nullptr) return total;
  std::array<double, VertexSums::kCount> values{};
  total.put(values.data());
  system.part()->sum(values.data(), VertexSums::kCount);
  total.take(values.data());
  return total;
}

}  // namespace

MechanicalSystem::MechanicalSystem(TetMesh mesh, const MaterialField& material, double density)
    : MechanicalSystem(std::move(mesh), {BodyRegion{material, density}}, {}) {}

MechanicalSystem::MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                                   const std::vector<int>& region_of_element, VolumeRule volume)
    : mesh_(std::move(mesh)),
      rest_(mesh_),
      elastic_(rest_, element_materials_of(regions, volume), region_of_element),
      viscous_(elastic_),
      density_(rest_.element_count()),
      mass_(Vector::Zero(mesh_.vertex_count())),
      constraints_(mesh_.vertex_count()) {
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
    int a = 0;
    for (const Index v : rest_.nodes(e)) mass_[v] += mass_share(e, a++);
  }
  add_shared(part(), mass_, 1);
  inverse_mass_ = mass_.cwiseInverse();
  total_mass_ = mass_.sum();
  if (part() != nullptr) {
    owned_mass_ = mass_.head(owned_vertex_count());
    own_mass_ = owned_mass_.sum();
    total_mass_ = sum_over_parts(part(), own_mass_);
  }
  if (part() != nullptr && (volume == VolumeRule::kNodal || rest_.is_quadratic())) {
    throw InputError(
        "Several processes can hold a body of linear tetrahedra with volumes of elements only: "
        "take "
        "mesh.element = \"linear\" and mesh.volume = \"element\", or one process.");
  }
  if (volume == VolumeRule::kNodal && rest_.is_quadratic()) {
    throw InputError(
        "mesh.volume = \"nodal\" is for linear tetrahedra, and the mesh has quadratic ones, which "
        "do "
        "not need it: leave it out, or take mesh.element = \"linear\".");
  }
  if (volume == VolumeRule::kNodal) {
    materials_ = materials_of(regions);
    nodal_volume_ = std::make_unique<NodalVolume>(elastic_, materials_);
  }
  list_terms();
}

MechanicalSystem::~MechanicalSystem() = default;

std::vector<Index> MechanicalSystem::elements_of(Index region_index) const {
  std::vector<Index> elements;
  for (Index e = 0; e < rest_.element_count(); ++e) {
    if (region(e) == region_index) elements.push_back(e);
  }
  return elements;
}

void MechanicalSystem::set_material(Index region, const MaterialField& material) {
  const auto index = static_cast<std::size_t>(region);
  if (!nodal_volume_) {
    elastic_.set_material(index, material);
    return;
  }
  elastic_.set_material(index, NodalVolume::without_volumetric_part(material));
  nodal_volume_->set_material(index, material);
  materials_.at(index) = material;
}

LameParameters MechanicalSystem::lame(Index e) const {
  if (!nodal_volume_) return elastic_.lame(e);
  return initial_lame(materials_[static_cast<std::size_t>(region(e))].at(e));
}

EvaluationStatus MechanicalSystem::elastic_energy(const Positions& q, double& energy) const {
  const EvaluationStatus status = elastic_.value(q, energy);
  if (nodal_volume_ && status.ok()) energy += nodal_volume_->energy(q);
  return status;
}

EvaluationStatus MechanicalSystem::elastic_energy_and_gradient(const Positions& q, double& energy,
                                                               Vector& gradient) const {
  if (nodal_volume_) return nodal_volume_->elastic_energy_and_gradient(q, energy, gradient);
  if (part() != nullptr) {
    return BlockAccess::value_and_gradient(elastic_, q, *part(), energy, gradient);
  }
  return elastic_.value_and_gradient(q, energy, gradient);
}

Vector MechanicalSystem::elastic_energies_by_region(const Vector& q) const {
  Vector energies = elastic_.energies_by_material(q);
  if (nodal_volume_) energies += nodal_volume_->energies_by_material(q);
  sum_over_parts(part(), energies.data(), energies.size());
  return energies;
}

void MechanicalSystem::elastic_energy_densities(const Vector& q, Vector& densities) const {
  elastic_.energy_densities(q, densities);
  if (nodal_volume_) nodal_volume_->add_energy_densities(q, densities);
}

Matrix3 MechanicalSystem::first_piola(Index e, const Vector& q) const {
  Matrix3 stress = elastic_.first_piola(e, q);
  if (!nodal_volume_) return stress;
  const Matrix3 f = deformation_gradient(rest_.point(e), 0, rest_.gather(q, e));
  Matrix3 cofactors;
  for (int k = 0; k < 3; ++k) {
    cofactors.col(k) = Vector3(f.col((k + 1) % 3)).cross(Vector3(f.col((k + 2) % 3)));
  }
  return stress + nodal_volume_->mean_tension(e, q) * cofactors;
}

ElasticPotential::StiffnessSums MechanicalSystem::stiffness_sums(double extra_modulus) const {
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

Constraints MechanicalSystem::set_constraints(Constraints constraints) {
  if (constraints.coordinates().dof_count() != dof_count()) {
    throw InputError("The constraints are for another mesh: the number of vertices differs.");
  }
  Constraints former = std::exchange(constraints_, std::move(constraints));
  set_pressures(pressure_.list());  // it depends on what the vertices of its rim may do
  return former;
}

void MechanicalSystem::set_damping(const Damping& damping) {
  for (const auto& [name, value] : {std::pair{"drag", damping.drag},
                                    {"mass_damping", damping.mass_damping},
                                    {"viscosity", damping.viscosity}}) {
    const std::string refusal = kDampingRange.refusal(value);
    if (!refusal.empty()) throw InputError(fmt::format("damping.{} = {}{}", name, value, refusal));
  }
  damping_ = damping;
  vertex_damping_ = VertexDamping(damping);
}

void MechanicalSystem::check(const ExternalForce& force) const {
  if (!force.vector.allFinite() || !force.vectors.allFinite()) {
    throw InputError("A user force is not finite.");
  }
  if (force.vectors.size() > 0 &&
      (force.vectors.rows() != 3 ||
       force.vectors.cols() != static_cast<Index>(force.vertices.size()))) {
    throw InputError(
        fmt::format("A user force needs one vector for each of its {} vertices, not a matrix of {} "
                    "x {}.",
                    force.vertices.size(), force.vectors.rows(), force.vectors.cols()));
  }
  for (const Index v : force.vertices) {
    if (v < 0 || v >= vertex_count()) {
      throw InputError("A user force acts on vertex " + std::to_string(v) +
                       ", which the mesh does not have.");
    }
  }
}

void MechanicalSystem::add_force(ExternalForce force) {
  check(force);
  external_forces_.list().push_back(std::move(force));
}

void MechanicalSystem::set_force(std::size_t index, ExternalForce force) {
  check(force);
  external_forces_.list().at(index) = std::move(force);
}

void MechanicalSystem::set_forces(std::vector<ExternalForce> forces) {
  for (const ExternalForce& force : forces) check(force);
  external_forces_.list() = std::move(forces);
}

void MechanicalSystem::set_pressures(std::vector<PressureLoad> pressures) {
  for (const PressureLoad& pressure : pressures) {
    if (!std::isfinite(pressure.value)) throw InputError("A pressure is not finite.");
    if (pressure.triangles.empty() && pressure.quadratic_faces.empty()) {
      throw InputError("A pressure acts on no triangle.");
    }
    const auto check_vertices = [&](const auto& face) {
      for (const Index v : face) {
        if (v >= 0 && v < vertex_count()) continue;
        throw InputError(
            fmt::format("A pressure acts on vertex {}, which the mesh does not have.", v));
      }
    };
    for (const auto& triangle : pressure.triangles) check_vertices(triangle);
    for (const auto& face : pressure.quadratic_faces) check_vertices(face);
  }
  if (pressures.empty()) {
    pressure_ = {};
    return;
  }
  const Vector rest = mesh_.rest_positions();
  pressure_ = SurfacePressure(std::move(pressures), rest, coordinates_at_rest(constraints_, rest));
}

void MechanicalSystem::list_terms() {
  terms_ = {&environment_, &vertex_damping_, &constraints_.springs(), &external_forces_,
            &pressure_};
  for (const auto& term : added_terms_) terms_.push_back(term.get());
}

void MechanicalSystem::add_force_term(std::shared_ptr<const ForceTerm> term) {
  if (!term) throw InputError("A force term is needed, not a null pointer.");
  const std::string name = term->name();
  if (!is_column_name(name)) {
    throw InputError("The force term \"" + name +
                     "\" needs a name of lower-case letters, digits and underscores.");
  }
  const bool taken = name == "kinetic" || name == "elastic" || name == "total" ||
                     std::any_of(terms_.begin(), terms_.end(),
                                 [&](const ForceTerm* other) { return other->name() == name; });
  if (taken) throw InputError("The name \"" + name + "\" of a force term is in use already.");
  if (term->has_potential() && term->account() == EnergyAccount::kNone) {
    throw InputError("The force term \"" + name +
                     "\" has a potential: its energy needs an account (ForceTerm::account()).");
  }
  added_terms_.push_back(std::move(term));
  list_terms();
}

bool MechanicalSystem::has_load_of_position() const {
  return std::any_of(terms_.begin(), terms_.end(), [](const ForceTerm* term) {
    return term->has_load() && term->load_depends_on_position();
  });
}

void MechanicalSystem::external_force(const ForcePoint& at, Vector& f) const {
  const bool any = std::any_of(terms_.begin(), terms_.end(),
                               [](const ForceTerm* term) { return term->has_load(); });
  f.setZero(any ? dof_count() : 0);
  for (const ForceTerm* term : terms_) {
    if (term->has_load()) term->add_load(at, f);
  }
}

void MechanicalSystem::applied_force(const ForcePoint& at, Vector& f) const {
  external_force(at, f);
  for (const ForceTerm* term : terms_) {
    if (!term->has_potential() || term->account() != EnergyAccount::kExternalWork) continue;
    if (f.size() == 0) f.setZero(dof_count());
    f = -f;
    term->add_gradient(at, f);
    f = -f;
  }
}

void MechanicalSystem::add_damping_force(const Vector& q, double time, const Vector& v,
                                         Vector& force) const {
  if (std::none_of(terms_.begin(), terms_.end(),
                   [](const ForceTerm* term) { return term->has_dissipation(); })) {
    return;
  }
  force = -force;
  for (const ForceTerm* term : terms_) {
    if (term->has_dissipation()) term->add_dissipation_gradient(force_point(q, time), v, force);
  }
  force = -force;
}

bool MechanicalSystem::is_dissipative() const {
  return damping_.viscosity > 0.0 ||
         std::any_of(terms_.begin(), terms_.end(),
                     [](const ForceTerm* term) { return term->has_dissipation(); });
}

const ForceTerm* MechanicalSystem::undefined_term(const Vector& q, double time,
                                                  Index& vertex) const {
  for (const ForceTerm* term : terms_) {
    if (!term->has_potential()) continue;
    vertex = term->undefined_vertex(energy_point(q, time));
    if (vertex >= 0) return term;
    if (term == &environment_ || term->is_quadratic()) continue;
    if (!std::isfinite(term->energy(energy_point(q, time)))) return term;
  }
  return nullptr;
}

State MechanicalSystem::rest_state() const {
  State state;
  state.position = mesh_.rest_positions();
  state.momentum = Vector::Zero(dof_count());
  state.velocity = Vector::Zero(dof_count());
  return state;
}

void MechanicalSystem::add_viscous_force(const Vector& q, const Vector& v, Vector& force) const {
  if (!(damping_.viscosity > 0.0)) return;
  if (part() == nullptr) {
    viscous_.add_force(damping_.viscosity, q, v, force);
    return;
  }
  Vector own = Vector::Zero(force.size());
  viscous_.add_force(damping_.viscosity, q, v, own);
  add_shared(part(), own, 3);
  force += own;
}

double MechanicalSystem::restricted_norm(const Vector& full) const {
  if (part() == nullptr) return coordinates().restricted_norm(full);
  double sum = 0.0;
  for (Index v = 0; v < owned_vertex_count(); ++v) {
    const Vector3 own = vertex_block(full, v);
    if (coordinates().is_free(v)) {
      sum += own.squaredNorm();
      continue;
    }
    const FreeCoordinates::VertexMap map = coordinates().map(v);
    for (int i = 0; i < map.count; ++i) {
      const double along = Vector3(map.columns.col(i)).dot(own);
      sum += along * along;
    }
  }
  return std::sqrt(sum_over_parts(part(), sum));
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

void MechanicalSystem::use_consistent_weights() {
  weights_ = rest_.is_quadratic() ? consistent_weights(*this) : Vector();
}

Vector MechanicalSystem::element_weights(Index e) const {
  if (weights_.size() > 0) return element_mass_matrix(rest_, e).rowwise().sum();
  Vector weights(static_cast<Index>(rest_.nodes(e).size()));
  for (Index a = 0; a < weights.size(); ++a) {
    weights[a] = rest_.volume(e) * rest_.mass_fraction(static_cast<int>(a));
  }
  return weights;
}

Vector3 MechanicalSystem::center_of_mass(const Vector& q) const {
  return sums(*this, q, q).first_moment / total_mass();
}

Vector3 MechanicalSystem::own_first_moment(const Vector& q) const {
  return own_sums(*this, q, q).first_moment;
}

double MechanicalSystem::kinetic_energy(const Vector& momentum) const {
  return 0.5 * sums(*this, momentum, momentum).twice_kinetic;
}

Vector MechanicalSystem::kinetic_energies_by_region(const Vector& momentum) const {
  Vector energies = Vector::Zero(region_count());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    const double mass = element_mass(e);
    int a = 0;
    for (const Index v : rest_.nodes(e)) {
      energies[region(e)] += 0.5 * mass * rest_.mass_fraction(a++) *
                             (vertex_block(momentum, v) / mass_[v]).squaredNorm();
    }
  }
  sum_over_parts(part(), energies.data(), energies.size());
  return energies;
}

EvaluationStatus MechanicalSystem::energies(const State& state, Energies& energies) const {
  Momenta ignored;
  double springs = 0.0;
  vertex_balance(state, energies, ignored, springs);
  double elastic = 0.0;
  EvaluationStatus status = elastic_energy(state.position, elastic);
  elastic = sum_over_parts(part(), elastic);
  energies.set_elastic(elastic);
  if (!everywhere(part(), status.ok()) && status.ok()) status.failed_element = 0;
  return status;
}

Momenta MechanicalSystem::momenta(const State& state) const {
  const VertexSums total = sums(*this, state.position, state.momentum);
  return {total.linear, total.angular, total.linear_scale, total.angular_scale};
}

std::size_t MechanicalSystem::balance_share_count() const {
  std::size_t count = VertexSums::kCount + 1;
  for (const ForceTerm* term : terms_) {
    if (term->account() == EnergyAccount::kStored && term->has_potential()) ++count;
  }
  return count;
}

// The sums over vertices, the energies of the terms, and at the end those of springs, of which a part may have none.
std::vector<double> MechanicalSystem::balance_shares(const State& state) const {
  std::vector<double> own(VertexSums::kCount, 0.0);
  own_sums(*this, state.position, state.momentum).put(own.data());
  for (const ForceTerm* term : terms_) {
    if (term->account() != EnergyAccount::kStored || !term->has_potential()) continue;
    own.push_back(term->energy(energy_point(state.position, state.time)));
  }
  own.push_back(spring_energies(state));
  return own;
}

double MechanicalSystem::spring_energies(const State& state) const {
  double sum = 0.0;
  for (const ForceTerm* term : terms_) {
    if (!term->has_potential() || term->account() != EnergyAccount::kConstraintWork) continue;
    sum += std::abs(term->energy(energy_point(state.position, state.time)));
  }
  return sum;
}

void MechanicalSystem::vertex_balance(const State& state, Energies& energies, Momenta& momenta,
                                      double& springs, const std::vector<double>& sums) const {
  VertexSums total;
  std::vector<double> own = sums;
  if (part() == nullptr) {
    total = own_sums(*this, state.position, state.momentum);
    springs = spring_energies(state);
  } else {
    if (own.empty()) {
      own = balance_shares(state);
      part()->sum(own.data(), static_cast<Index>(own.size()));
    }
    total.take(own.data());
    springs = own.back();
  }
  std::size_t next = VertexSums::kCount;
  momenta = {total.linear, total.angular, total.linear_scale, total.angular_scale};
  energies.set_kinetic(0.5 * total.twice_kinetic);
  std::size_t extra = 0;
  for (const ForceTerm* term : terms_) {
    if (term->account() != EnergyAccount::kStored) continue;
    double energy = 0.0;
    const std::optional<Vector3> acceleration = term->uniform_acceleration();
    if (!own.empty()) {
      energy = term->has_potential() ? own[next++] : 0.0;
    } else if (acceleration && weights_.size() == 0) {
      // A difference, as minus zero would be written where there is no energy.
      energy = 0.0 - acceleration->dot(total.first_moment);
    } else if (term->has_potential()) {
      energy = term->energy(force_point(state.position, state.time));
    }
    if (term == &environment_) {
      energies.set_environment(energy);
    } else {
      energies.set_extra(extra++, term->name(), energy);
    }
  }
}

}  // namespace tetraction
