#include "frame_fields.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "tetraction/dynamics/derived_fields.h"
#include "tetraction/dynamics/nodal_fields.h"
#include "tetraction/simulation/output_fields.h"

namespace tetraction {
namespace {

Matrix columns(const Vector& field) {
  return field.reshaped(3, field.size() / 3);
}

Matrix fixed_flags(const MechanicalSystem& system) {
  Matrix fixed(1, system.vertex_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    fixed(0, v) = system.constraints().is_constrained(v) ? 1.0 : 0.0;
  }
  return fixed;
}

Matrix regions(const MechanicalSystem& system) {
  Matrix region(1, system.mesh().tetrahedron_count());
  for (Index e = 0; e < region.cols(); ++e) {
    region(0, e) = system.region_count() > 1 ? system.region(e) : system.mesh().region(e);
  }
  return region;
}

// Von Mises stresses of columns of six components.
Matrix von_mises_of(const Matrix& stress) {
  Matrix values(1, stress.cols());
  for (Index i = 0; i < stress.cols(); ++i) {
    const auto s = stress.col(i);
    Matrix3 tensor;
    tensor << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    values(0, i) = von_mises(tensor);
  }
  return values;
}

// Computes fields of a state. Those that come from one loop over the elements are computed together.
class FieldMaker {
 public:
  explicit FieldMaker(const Session& session)
      : session_(session), system_(session.system()), state_(session.state()) {}

  /// Fields in ElementFields get their values from move_element_fields().
  FrameField make(const std::string& name) {
    if (member_of(name) != nullptr) return {name, {}, false};
    return {name, values(name), name == "fixed" || name == "region"};
  }
  /// To be called when no more fields are made from these, which are not copied, because a large mesh
  /// would need much memory for them.
  void move_element_fields(std::vector<FrameField>& fields) {
    for (FrameField& field : fields) {
      Matrix ElementFields::*const member = member_of(field.name);
      if (member == nullptr) continue;
      elements();
      field.values = std::move(elements_.*member);
    }
  }

 private:
  static Matrix ElementFields::*member_of(const std::string& name) {
    if (name == "cauchy_stress") return &ElementFields::cauchy_stress;
    if (name == "green_strain") return &ElementFields::green_strain;
    if (name == "von_mises") return &ElementFields::von_mises;
    if (name == "jacobian") return &ElementFields::jacobian;
    if (name == "energy_density") return &ElementFields::energy_density;
    return nullptr;
  }
  const ElementFields& elements() {
    if (!has_elements_) elements_ = element_fields(system_, state_.position);
    has_elements_ = true;
    return elements_;
  }
  const NodalFields& vertices() {
    if (!has_vertices_) vertices_ = nodal_fields(system_, state_.position);
    has_vertices_ = true;
    return vertices_;
  }
  // The values at the vertices: of quadratic tetrahedra those of `own`, of linear ones means of the
  // values of the tetrahedra.
  Matrix average(Matrix NodalFields::*own, Matrix ElementFields::*of_elements) {
    return is_quadratic_ ? vertices().*own : nodal_average(system_, elements().*of_elements);
  }
  Matrix nodal_stress() {
    return average(&NodalFields::cauchy_stress, &ElementFields::cauchy_stress);
  }
  // Quadratic tetrahedra have stresses at their vertices, which need no recovery.
  Matrix recovered_stress() {
    return is_quadratic_ ? nodal_stress() : recovered_field(system_, elements().cauchy_stress);
  }

  Matrix values(const std::string& name) {
    if (name == "displacement") {
      return columns(state_.position - system_.mesh().rest_positions());
    }
    if (name == "velocity") return columns(state_.velocity);
    if (name == "momentum") return columns(state_.momentum);
    if (name == "external_force") return columns(session_.external_force());
    if (name == "reaction_force") return columns(session_.reaction_force());
    if (name == "fixed") return fixed_flags(system_);
    if (name == "deformation") return deformation_field(system_, state_.position);
    if (name == "region") return regions(system_);
    if (name == "first_piola") return first_piola_stress(system_, state_.position);
    if (name == "principal_stresses") return principal_stresses(elements().cauchy_stress);
    if (name == "pressure") return pressures(elements().cauchy_stress);
    if (name == "cauchy_stress_nodal") return nodal_stress();
    if (name == "green_strain_nodal") {
      return average(&NodalFields::green_strain, &ElementFields::green_strain);
    }
    if (name == "von_mises_nodal") {
      return average(&NodalFields::von_mises, &ElementFields::von_mises);
    }
    if (name == "pressure_nodal") {
      return is_quadratic_ ? pressures(nodal_stress())
                           : nodal_average(system_, pressures(elements().cauchy_stress));
    }
    if (name == "jacobian_nodal") {
      return average(&NodalFields::jacobian, &ElementFields::jacobian);
    }
    if (name == "cauchy_stress_recovered") return recovered_stress();
    if (name == "von_mises_recovered") {
      return is_quadratic_ ? vertices().von_mises : von_mises_of(recovered_stress());
    }
    throw std::logic_error(fmt::format("the field {} is in output_fields() only", name));
  }

  const Session& session_;
  const MechanicalSystem& system_;
  const State& state_;
  bool is_quadratic_ = system_.mesh().is_quadratic();
  ElementFields elements_;
  bool has_elements_ = false;
  NodalFields vertices_;
  bool has_vertices_ = false;
};

}  // namespace

Frame make_frame(const Session& session, const std::vector<std::string>& names) {
  Frame frame;
  frame.time = session.time();
  frame.step = session.step_number();
  FieldMaker maker(session);
  const VolumeRule rule =
      session.system().nodal_volume() == nullptr ? VolumeRule::kElement : VolumeRule::kNodal;
  for (const OutputField& field : output_fields()) {
    if (!has_field(names, field, rule, session.system().mesh().is_quadratic())) continue;
    (field.on_cells ? frame.cell_fields : frame.point_fields).push_back(maker.make(field.name));
  }
  maker.move_element_fields(frame.cell_fields);
  return frame;
}

}  // namespace tetraction
