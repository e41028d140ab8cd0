// Fields worked out from a state for people to look at: strain, stress, shape without motion.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Per element; symmetric tensors as six rows in the order XX YY ZZ XY YZ XZ.
struct ElementFields {
  Matrix cauchy_stress;   ///< σ = P Fᵀ/J, Pa (6 × elements)
  Matrix green_strain;    ///< E = ½(FᵀF − I) (6 × elements)
  Matrix von_mises;       ///< √(3/2 s:s) of the deviator s of σ, Pa (1 × elements)
  Matrix jacobian;        ///< J (1 × elements)
  Matrix energy_density;  ///< Ψ, J/m³ (1 × elements)
};

/// W must be defined at q.
ElementFields element_fields(const MechanicalSystem& system, const Vector& q);

/// The two of them that cost less than all: √(3/2 s:s), Pa, and J, one per element. W must be defined
/// at q for the stress.
Vector von_mises_stress(const MechanicalSystem& system, const Vector& q);
Vector volume_ratios(const MechanicalSystem& system, const Vector& q);

/// Displacement less the best-fit rigid motion, 3 × vertices: q − (R (X − X̄) + q̄), with mass-
/// weighted centres and R the rotation that brings the rest shape nearest to q (shape matching,
/// Müller et al. 2005, by the polar decomposition of Σ m (q − q̄)(X − X̄)ᵀ). R is a proper rotation
/// even for flat or mirrored shapes.
Matrix deformation_field(const MechanicalSystem& system, const Vector& q);

}  // namespace tetraction
