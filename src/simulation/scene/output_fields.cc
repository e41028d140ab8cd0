#include "tetraction/simulation/output_fields.h"

#include <algorithm>

#include "tetraction/simulation/frame_format.h"

namespace tetraction {

const std::vector<OutputField>& output_fields() {
  static const std::vector<OutputField> fields{
      {"displacement", "m", false, true},
      {"velocity", "m/s", false, true},
      {"momentum", "kg m/s", false, true},
      {"external_force", "N", false, true},
      {"reaction_force", "N", false, true},
      {"fixed", "", false, true},
      {"deformation", "m", false, true},
      {"cauchy_stress_nodal", "Pa", false, false, false, true},
      {"green_strain_nodal", "", false, false},
      {"von_mises_nodal", "Pa", false, false, false, true},
      {"pressure_nodal", "Pa", false, false, true},
      {"jacobian_nodal", "", false, false, true},
      {"cauchy_stress_recovered", "Pa", false, false},
      {"von_mises_recovered", "Pa", false, false},
      {"cauchy_stress", "Pa", true, true},
      {"green_strain", "", true, true},
      {"von_mises", "Pa", true, true},
      {"jacobian", "", true, true},
      {"energy_density", "J/m³", true, true},
      {"region", "", true, true},
      {"first_piola", "Pa", true, false},
      {"principal_stresses", "Pa", true, false},
      {"pressure", "Pa", true, false}};
  return fields;
}

bool has_field(const std::vector<std::string>& names, const OutputField& field, VolumeRule volume,
               bool is_quadratic) {
  const auto has = [&](const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const bool is_default = field.is_default ||
                          (field.is_nodal_default && volume == VolumeRule::kNodal) ||
                          (field.is_quadratic_default && is_quadratic);
  return has(field.name) || (is_default && (names.empty() || has(kDefaultFields)));
}

}  // namespace tetraction
