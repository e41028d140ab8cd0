// Centre of mass and inertia of a body.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

struct MassProperties {
  Vector3 center = Vector3::Zero();  ///< m
  Matrix3 inertia = Matrix3::Zero();  ///< ∫ ρ (|r|² 1 − r rᵀ) dV with r from the centre, kg m²
};

/// The properties of the undeformed body with its mass spread over the elements, exact for straight edges.
MassProperties mass_properties(const MechanicalSystem& system);
/// The same with the lumped masses of the vertices, with which time steps are made. They lie at vertices, so
/// that moments of inertia are too large, and a mesh whose diagonals favour a direction gives products of
/// inertia to symmetric bodies. Both errors fall with the square of the size of the elements.
MassProperties lumped_mass_properties(const MechanicalSystem& system);

}  // namespace tetraction
