// Fields for display that are computed from a state: strain, stress, deformation without rigid
// motion.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Fields with one column per element. Symmetric tensors have six rows in the order XX YY ZZ XY YZ
/// XZ.
struct ElementFields {
  Matrix cauchy_stress;   ///< σ = P Fᵀ/J, Pa (6 × elements)
  Matrix green_strain;    ///< E = ½(FᵀF − I) (6 × elements)
  Matrix von_mises;       ///< √(3/2 s:s) of the deviator s of σ, Pa (1 × elements)
  Matrix jacobian;        ///< J (1 × elements)
  Matrix energy_density;  ///< Ψ, J/m³ (1 × elements)
};

/// Computes all fields. W must be defined at q.
ElementFields element_fields(const MechanicalSystem& system, const Vector& q);

/// Compute one of the fields only, which takes less time: √(3/2 s:s), Pa, or J, one per element.
/// For the stress W must be defined at q.
Vector von_mises_stress(const MechanicalSystem& system, const Vector& q);
Vector volume_ratios(const MechanicalSystem& system, const Vector& q);

/// The displacement less the best-fit rigid motion, 3 × vertices: q − (R (X − X̄) + q̄). The
/// centres X̄ and q̄ are mass-weighted. R is the rotation that brings the rest shape nearest to q.
/// It comes from the polar decomposition of Σ m (q − q̄)(X − X̄)ᵀ (shape matching, Müller et al.
/// 2005). R is a proper rotation even for flat or mirrored shapes.
Matrix deformation_field(const MechanicalSystem& system, const Vector& q);

/// The largest displacement from rest.
struct Displacement {
  double length = 0.0;  ///< m
  Index vertex = 0;
};
Displacement largest_displacement(const MechanicalSystem& system, const Vector& q);

/// The sum of the forces of all vertices (3 per vertex, N).
Vector3 resultant(const Vector& force);

}  // namespace tetraction
