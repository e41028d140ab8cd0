// Where the volumetric part of the elastic energy is taken.
#pragma once

#include <array>

#include "tetraction/core/enum_names.h"

namespace tetraction {

/// How the volumetric part U(J) of a material enters the elastic energy.
enum class VolumeRule {
  kElement,  ///< Σ_e V_e U(J_e): with the volume ratio of every tetrahedron
  kNodal  ///< Σ_a V_a U(J_a): with averages at the vertices (dynamics/nodal_volume/nodal_volume.h)
};

template <>
struct EnumNames<VolumeRule> {
  static constexpr std::array names{"element", "nodal"};
};

}  // namespace tetraction
