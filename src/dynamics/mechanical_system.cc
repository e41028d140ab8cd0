#include "tetraction/dynamics/mechanical_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "tetraction/core/error.h"
#include "tetraction/dynamics/consistent_mass.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// The motions that vertices may make. Those count as free that supports move, or hold elsewhere than at rest.
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

}  // namespace

MechanicalSystem::MechanicalSystem(TetMesh mesh, const MaterialField& material, double density)
    : MechanicalSystem(std::move(mesh), {BodyRegion{material, density}}, {}) {}

MechanicalSystem::MechanicalSystem(TetMesh mesh, const std::vector<BodyRegion>& regions,
                                   const std::vector<int>& region_of_element, VolumeRule volume)
    : Body(std::move(mesh), regions, region_of_element, volume),
      viscous_(elastic()),
      constraints_(vertex_count()) {
  list_terms();
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
    throw InputError(fmt::format(
        "A user force needs one vector for each of its {} vertices, not a matrix of {} x {}.",
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
  const Vector rest = mesh().rest_positions();
  pressure_ = SurfacePressure(std::move(pressures), rest, coordinates_at_rest(constraints_, rest));
}

void MechanicalSystem::list_terms() {
  terms_ = {&environment_,     &vertex_damping_, &constraints_.springs(),
            &external_forces_, &pressure_,       &pull_};
  if (contact_) terms_.push_back(contact_.get());
  for (const auto& term : added_terms_) terms_.push_back(term.get());
}

std::shared_ptr<const Contact> MechanicalSystem::set_contact(
    std::shared_ptr<const Contact> contact) {
  std::swap(contact_, contact);
  list_terms();
  return contact;
}

void MechanicalSystem::add_force_term(std::shared_ptr<const ForceTerm> term) {
  if (!term) throw InputError("A force term is needed, not a null pointer.");
  const std::string name = term->name();
  if (!is_column_name(name)) {
    throw InputError("The force term \"" + name +
                     "\" needs a name of lower-case letters, digits and underscores.");
  }
  const bool taken = name == "kinetic" || name == "elastic" || name == "total" ||
                     name == "contact" ||
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

void MechanicalSystem::set_force_term(std::shared_ptr<const ForceTerm> term) {
  const auto same = [&](const auto& added) { return term && added->name() == term->name(); };
  const auto old = std::find_if(added_terms_.begin(), added_terms_.end(), same);
  if (old == added_terms_.end()) {
    add_force_term(std::move(term));
    return;
  }
  *old = std::move(term);
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

void MechanicalSystem::set_velocity(State& state, const Vector& velocity) const {
  state.momentum = momentum_of(velocity);
  project_to_constraints(constraints_, mass(), state.position, state.time, state.momentum);
  state.velocity = velocity_of(state.momentum);
}

void MechanicalSystem::use_consistent_weights() {
  weights_ = rest().is_quadratic() ? consistent_weights(*this)
             : has_moved_masses()  ? lumped_masses()
                                   : Vector();
}

Vector MechanicalSystem::element_weights(Index e) const {
  if (weights_.size() > 0) return element_mass_matrix(rest(), e).rowwise().sum();
  Vector weights(static_cast<Index>(rest().nodes(e).size()));
  for (Index a = 0; a < weights.size(); ++a) {
    weights[a] = rest().volume(e) * rest().mass_fraction(static_cast<int>(a));
  }
  return weights;
}

}  // namespace tetraction
