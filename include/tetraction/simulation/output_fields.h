// The fields that the frames of a run can have: output.fields of a scene.
#pragma once

#include <string>
#include <vector>

#include "tetraction/dynamics/nodal_volume/volume_rule.h"

namespace tetraction {

/// One array of a frame.
struct OutputField {
  const char* name;
  const char* unit;  ///< SI, "" for a pure number
  bool on_cells;     ///< one value for each tetrahedron, otherwise for each vertex
  bool is_default;   ///< whether frames have it if the scene does not say which fields they have
  /// Whether it is a default field of bodies with VolumeRule::kNodal.
  bool is_nodal_default = false;
  /// Whether it is a default field of bodies with quadratic tetrahedra.
  bool is_quadratic_default = false;
};

/// All fields, in the order in which frames have them.
const std::vector<OutputField>& output_fields();

/// In a list of fields it stands for all default fields: ["default", "pressure"].
inline constexpr const char* kDefaultFields = "default";

/// Whether a list of names, as OutputSettings::fields, has this field. An empty list has the default
/// ones of a body with this rule and linear or quadratic tetrahedra.
bool has_field(const std::vector<std::string>& names, const OutputField& field,
               VolumeRule volume = VolumeRule::kElement, bool is_quadratic = false);

}  // namespace tetraction
