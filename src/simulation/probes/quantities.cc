#include "tetraction/simulation/quantities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "simulation/session/contact_point.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

// The fields of the present state of a session. Those that several quantities need are computed when the first of
// these is.
class BodyFields {
 public:
  explicit BodyFields(const Session& of) : BodyFields(of, of.present_state()) {}
  BodyFields(const Session& of, const State& at)
      : session(of), system(of.system()), state(at), q(at.position) {}

  // Computes two fields in one loop if the list has both. They are taken afterwards, once.
  void prepare(const std::vector<const Quantity*>& list) {
    const auto has = [&](auto name) { return std::ranges::count(list, find_quantity(name)) > 0; };
    if (has("energy_density") && (has("cauchy_stress") || has("von_mises"))) {
      stresses_and_energies(system, q, stress_, energy_);
    }
    if (has("green_strain") && has("jacobian")) strains_and_ratios(system, q, strain_, ratio_);
  }
  Matrix take_energy_density() {
    return energy_.size() == 0 ? energy_densities(system, q) : std::move(energy_);
  }
  Matrix take_green_strain() {
    return strain_.size() == 0 ? green_strains(system, q) : std::move(strain_);
  }
  Matrix take_jacobian() {
    return ratio_.size() == 0 ? Matrix(volume_ratios(system, q).transpose()) : std::move(ratio_);
  }
  const Matrix& stress() {
    if (stress_.size() == 0) stress_ = cauchy_stresses(system, q);
    return stress_;
  }
  // For the last quantity that is asked for. A copy would need much memory for a large mesh.
  Matrix take_stress() {
    stress();
    return std::move(stress_);
  }
  const NodalFields& vertices() {
    if (!has_vertices_) vertices_ = nodal_fields(system, q);
    has_vertices_ = true;
    return vertices_;
  }
  // The values at the vertices: of quadratic tetrahedra those of `own`, of linear ones means of the
  // values of the tetrahedra.
  template <class OfElements>
  Matrix average(Matrix NodalFields::*own, const OfElements& of_elements) {
    return is_quadratic ? vertices().*own : nodal_average(system, of_elements());
  }
  Matrix nodal_stress() {
    return average(&NodalFields::cauchy_stress, [this]() -> const Matrix& { return stress(); });
  }
  // Quadratic tetrahedra have stresses at their vertices, which need no recovery.
  Matrix recovered_stress() {
    return is_quadratic ? nodal_stress() : recovered_field(system, stress());
  }

  const Session& session;
  const MechanicalSystem& system;
  const State& state;
  const Vector& q;
  const bool is_quadratic = system.mesh().is_quadratic();

 private:
  Matrix stress_;
  Matrix energy_;
  Matrix strain_;
  Matrix ratio_;
  NodalFields vertices_;
  bool has_vertices_ = false;
};

namespace {

Matrix fixed_flags(BodyFields& fields) {
  Matrix fixed(1, fields.system.vertex_count());
  for (Index v = 0; v < fixed.cols(); ++v) {
    fixed(0, v) = fields.system.constraints().is_constrained(v) ? 1.0 : 0.0;
  }
  return fixed;
}

Matrix region_numbers(BodyFields& fields) {
  const MechanicalSystem& system = fields.system;
  Matrix region(1, system.mesh().tetrahedron_count());
  for (Index e = 0; e < region.cols(); ++e) {
    region(0, e) = system.region_count() > 1 ? system.region(e) : system.mesh().region(e);
  }
  return region;
}

// The pressure of contact, or with `gap` the distance to the nearest obstacle.
Matrix contact_scalar(BodyFields& fields, bool gap) {
  const Contact* contact = fields.system.contact();
  Matrix values(1, fields.system.vertex_count());
  if (contact == nullptr) {
    values.setConstant(gap ? std::numeric_limits<double>::quiet_NaN() : 0.0);
    return values;
  }
  Vector pressure;
  Vector gaps;
  contact->fields(contact_point(fields.session, fields.state), pressure, gaps);
  for (Index v = 0; v < values.cols(); ++v) {
    values(0, v) = !gap                     ? pressure[v]
                   : std::isfinite(gaps[v]) ? gaps[v]
                                            : std::numeric_limits<double>::quiet_NaN();
  }
  return values;
}

Matrix contact_forces(BodyFields& fields) {
  Vector gradient = Vector::Zero(fields.system.dof_count());
  if (const Contact* contact = fields.system.contact(); contact != nullptr) {
    contact->add_gradient(contact_point(fields.session, fields.state), gradient);
  }
  return (0.0 - gradient.array()).matrix().reshaped(3, fields.system.vertex_count());
}

Matrix recovered_von_mises(BodyFields& fields) {
  if (fields.is_quadratic) return fields.vertices().von_mises;
  return von_mises_stresses(fields.recovered_stress());
}

Matrix nodal_pressures(BodyFields& fields) {
  return fields.is_quadratic ? pressures(fields.nodal_stress())
                             : nodal_average(fields.system, pressures(fields.stress()));
}

// The vector of a quantity; if the state has it, that of the state.
const Vector& vector_of(const Quantity& quantity, const BodyFields& fields) {
  const Vector& present = quantity.of_vertices(fields.session);
  for (Vector State::*const own : {&State::position, &State::velocity, &State::momentum}) {
    if (&present == &(fields.session.present_state().*own)) return fields.state.*own;
  }
  return present;
}

// The values of one vector for each vertex.
Matrix vertex_values(const Quantity& quantity, const BodyFields& fields) {
  const Vector& field = vector_of(quantity, fields);
  const Index count = fields.system.vertex_count();
  if (field.size() == 0) return Matrix::Zero(3, count);
  if (!quantity.is_relative) return field.reshaped(3, count);
  return (field - fields.system.mesh().rest_positions()).reshaped(3, count);
}

// Whether a quantity is one of the body, and not of an obstacle alone.
bool has_values(const Quantity& quantity) {
  return quantity.of_vertices != nullptr || quantity.of_body != nullptr;
}

std::vector<Quantity> all_quantities() {
  using enum ValueShape;
  using enum ValueDomain;
  using P = ProbeQuantity;
  using F = BodyFields;
  using N = NodalFields;
  return {
      {.name = "displacement",
       .unit = "m",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .probe = P::kDisplacement,
       .color = {"Displacement", 1},
       .is_relative = true,
       .of_vertices = [](const Session& s) -> const Vector& { return s.present_state().position; }},
      {.name = "position",
       .unit = "m",
       .shape = kVector,
       .frames = InFrames::kNone,
       .probe = P::kPosition,
       .of_vertices = [](const Session& s) -> const Vector& { return s.present_state().position; }},
      {.name = "velocity",
       .unit = "m/s",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .probe = P::kVelocity,
       .color = {"Speed", 2},
       .of_vertices = [](const Session& s) -> const Vector& { return s.present_state().velocity; }},
      {.name = "momentum",
       .unit = "kg m/s",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .probe = P::kMomentum,
       .is_sum = true,
       .of_vertices = [](const Session& s) -> const Vector& { return s.present_state().momentum; }},
      {.name = "external_force",
       .unit = "N",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .probe = P::kForce,
       .is_sum = true,
       .of_vertices = [](const Session& s) -> const Vector& { return s.present_external_force(); }},
      {.name = "reaction_force",
       .unit = "N",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .probe = P::kReaction,
       .is_sum = true,
       .color = {"Reaction", 6},
       .of_vertices = [](const Session& s) -> const Vector& { return s.reaction_force(); }},
      {.name = "fixed", .frames = InFrames::kDefault, .is_integral = true, .of_body = fixed_flags},
      {.name = "deformation",
       .unit = "m",
       .shape = kVector,
       .frames = InFrames::kDefault,
       .of_body = [](F& f) { return deformation_field(f.system, f.q); }},
      {.name = "contact_pressure",
       .unit = "Pa",
       .frames = InFrames::kContact,
       .color = {"Contact pressure", 11},
       .of_body = [](F& f) { return contact_scalar(f, false); }},
      {.name = "contact_force",
       .unit = "N",
       .shape = kVector,
       .frames = InFrames::kContact,
       .probe = P::kContactForce,
       .is_of_obstacle = true,
       .of_body = contact_forces},
      {.name = "contact_moment",
       .unit = "N m",
       .shape = kVector,
       .frames = InFrames::kNone,
       .probe = P::kContactMoment,
       .is_of_obstacle = true},
      {.name = "gap",
       .unit = "m",
       .frames = InFrames::kContact,
       .of_body = [](F& f) { return contact_scalar(f, true); }},
      {.name = "cauchy_stress_nodal",
       .unit = "Pa",
       .shape = kSymmetricTensor,
       .frames = InFrames::kQuadratic,
       .of_body = [](F& f) { return f.nodal_stress(); }},
      {.name = "green_strain_nodal",
       .shape = kSymmetricTensor,
       .of_body =
           [](F& f) {
             return f.average(&N::green_strain, [&] { return green_strains(f.system, f.q); });
           }},
      {.name = "von_mises_nodal",
       .unit = "Pa",
       .frames = InFrames::kQuadratic,
       .of_body =
           [](F& f) {
             return f.average(&N::von_mises, [&] { return von_mises_stresses(f.stress()); });
           }},
      {.name = "pressure_nodal",
       .unit = "Pa",
       .frames = InFrames::kNodal,
       .of_body = nodal_pressures},
      {.name = "jacobian_nodal",
       .frames = InFrames::kNodal,
       .of_body = [](F& f) { return f.average(&N::jacobian, [&] { return f.take_jacobian(); }); }},
      {.name = "cauchy_stress_recovered",
       .unit = "Pa",
       .shape = kSymmetricTensor,
       .of_body = [](F& f) { return f.recovered_stress(); }},
      {.name = "von_mises_recovered", .unit = "Pa", .of_body = recovered_von_mises},
      {.name = "cauchy_stress",
       .unit = "Pa",
       .shape = kSymmetricTensor,
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .probe = P::kCauchyStress,
       .color = {"Cauchy stress", 9, 0.0},
       .of_element =
           [](const ElementPlace& at, double* to) {
             Eigen::Map<Vector6>{to} = six_components(at.cauchy_stress());
           },
       .of_body = [](F& f) { return f.take_stress(); }},
      {.name = "green_strain",
       .shape = kSymmetricTensor,
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .of_body = [](F& f) { return f.take_green_strain(); }},
      {.name = "von_mises",
       .unit = "Pa",
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .probe = P::kVonMises,
       .color = {"von Mises stress", 3},
       .of_element = [](const ElementPlace& at,
                        double* to) { *to = von_mises(at.cauchy_stress()); },
       .of_body = [](F& f) { return von_mises_stresses(f.stress()); }},
      {.name = "jacobian",
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .probe = P::kJacobian,
       .color = {"Volume ratio J", 5, 1.0},
       .of_element = [](const ElementPlace& at, double* to) { *to = at.jacobian(); },
       .of_body = [](F& f) { return f.take_jacobian(); }},
      {.name = "energy_density",
       .unit = "J/m³",
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .color = {"Energy density", 4},
       .of_body = [](F& f) { return f.take_energy_density(); }},
      {.name = "region",
       .domain = kTetrahedra,
       .frames = InFrames::kDefault,
       .color = {"Region", 10},
       .is_integral = true,
       .of_body = region_numbers},
      {.name = "first_piola",
       .unit = "Pa",
       .shape = kTensor,
       .domain = kTetrahedra,
       .of_body = [](F& f) { return first_piola_stress(f.system, f.q); }},
      {.name = "principal_stresses",
       .unit = "Pa",
       .shape = kPrincipalValues,
       .domain = kTetrahedra,
       .color = {"Principal stresses", 8, 0.0},
       .of_body = [](F& f) { return principal_stresses(f.stress()); }},
      {.name = "pressure",
       .unit = "Pa",
       .domain = kTetrahedra,
       .color = {"Pressure", 7, 0.0},
       .of_body = [](F& f) { return pressures(f.stress()); }}};
}

}  // namespace

Matrix3 ElementPlace::cauchy_stress() const {
  return point == nullptr ? tetraction::cauchy_stress(system, tetrahedron, q)
                          : values_at(system, tetrahedron, *point, q).cauchy_stress;
}

double ElementPlace::jacobian() const {
  return point == nullptr ? volume_ratio(system, tetrahedron, q)
                          : values_at(system, tetrahedron, *point, q).jacobian;
}

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = all_quantities();
  return all;
}

const Quantity* find_quantity(const std::string& name) {
  const auto found = std::ranges::find_if(quantities(), [&](const Quantity& quantity) {
    return has_values(quantity) && name == quantity.name;
  });
  return found == quantities().end() ? nullptr : &*found;
}

const Quantity& named_quantity(const std::string& name) {
  if (const Quantity* found = find_quantity(name)) return *found;
  std::vector<const char*> known;
  for (const Quantity& quantity : quantities()) {
    if (has_values(quantity)) known.push_back(quantity.name);
  }
  refuse_name(name, "a quantity", known);
}

const Quantity& quantity_of(ProbeQuantity probe) {
  return *std::ranges::find(quantities(), probe, &Quantity::probe);
}

const std::vector<const char*>& component_endings(ValueShape shape) {
  static const std::vector<std::vector<const char*>> endings{
      {""},
      {"_x", "_y", "_z"},
      {"_xx", "_yy", "_zz", "_xy", "_yz", "_xz"},
      {"_xx", "_xy", "_xz", "_yx", "_yy", "_yz", "_zx", "_zy", "_zz"},
      {"_1", "_2", "_3"}};
  return endings[static_cast<std::size_t>(shape)];
}

std::vector<const Quantity*> frame_quantities() {
  std::vector<const Quantity*> list;
  for (const Quantity& quantity : quantities()) {
    if (quantity.frames != InFrames::kNone) list.push_back(&quantity);
  }
  return list;
}

std::vector<const Quantity*> chosen_quantities(const std::vector<std::string>& names,
                                               VolumeRule volume, bool is_quadratic,
                                               bool has_contact) {
  const auto has = [&](const char* name) { return std::ranges::count(names, name) > 0; };
  std::vector<const Quantity*> list = frame_quantities();
  std::erase_if(list, [&](const Quantity* quantity) {
    const bool is_default =
        quantity->frames == InFrames::kDefault ||
        (quantity->frames == InFrames::kNodal && volume == VolumeRule::kNodal) ||
        (quantity->frames == InFrames::kQuadratic && is_quadratic) ||
        (quantity->frames == InFrames::kContact && has_contact);
    return !has(quantity->name) && !(is_default && (names.empty() || has(kDefaultFields)));
  });
  return list;
}

const std::vector<const Quantity*>& color_quantities() {
  static const std::vector<const Quantity*> colors = [] {
    std::vector<const Quantity*> list;
    for (const Quantity& quantity : quantities()) {
      if (quantity.color.name != nullptr) list.push_back(&quantity);
    }
    std::ranges::sort(list, {}, [](const Quantity* quantity) { return quantity->color.place; });
    return list;
  }();
  return colors;
}

const Quantity& drawn_quantity(const Quantity& color, bool is_quadratic) {
  const Quantity* nodal =
      is_quadratic ? find_quantity(std::string(color.name) + "_nodal") : nullptr;
  return nodal != nullptr ? *nodal : color;
}

std::vector<Matrix> values_of(const Session& session, const std::vector<const Quantity*>& list) {
  BodyFields fields(session);
  fields.prepare(list);
  std::vector<Matrix> values(list.size());
  const auto of = [&](const Quantity& quantity) {
    return quantity.of_body != nullptr ? quantity.of_body(fields) : vertex_values(quantity, fields);
  };
  // The stress comes last, because it is taken from what others are computed from.
  const Quantity* stress = &quantity_of(ProbeQuantity::kCauchyStress);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i] != stress) values[i] = of(*list[i]);
  }
  const auto at = std::ranges::find(list, stress);
  if (at != list.end()) values[static_cast<std::size_t>(at - list.begin())] = fields.take_stress();
  return values;
}

Matrix values_of(const Session& session, const Quantity& quantity) {
  return values_of(session, quantity, session.present_state());
}

Matrix values_of(const Session& session, const Quantity& quantity, const State& state) {
  BodyFields fields(session, state);
  return quantity.of_body != nullptr ? quantity.of_body(fields) : vertex_values(quantity, fields);
}

}  // namespace tetraction
