// Measures by which the cause of a failed step is judged, of the body as a whole.
#pragma once

#include <limits>

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Forces are out of proportion if they would strain a part of the body by more than this.
inline constexpr double kAbsurdStrain = 100.0;

/// λ + 2μ of the softest and the stiffest element, Pa.
struct Moduli {
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
};
Moduli moduli_of(const MechanicalSystem& system);

/// The edge of a cube with the volume that belongs to a vertex, m.
double length_of_vertex(const MechanicalSystem& system);
/// The strain that the forces (3 per vertex, N) would make in the stiffest material: of the largest one on the section
/// that belongs to a vertex, or of all on the section of the body.
double strain_of(const MechanicalSystem& system, const Vector& forces);
/// The largest speed of a vertex relative to the centre of mass, m/s.
double fastest(const MechanicalSystem& system, const Vector& momentum);
/// The speed of pressure waves in the stiffest material, m/s.
double wave_speed(const MechanicalSystem& system);

}  // namespace tetraction
