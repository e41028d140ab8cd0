// Where the volumetric part of the elastic energy is taken.
#pragma once

namespace tetraction {

/// How the volumetric part U(J) of a material enters the elastic energy.
enum class VolumeRule {
  kElement,  ///< Σ_e V_e U(J_e): with the volume ratio of every tetrahedron
  kNodal  ///< Σ_a V_a U(J_a): with averages at the vertices (dynamics/nodal_volume/nodal_volume.h)
};

/// "element" or "nodal".
const char* to_string(VolumeRule rule);

}  // namespace tetraction
