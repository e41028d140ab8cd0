// The coefficients of the dissipative forces.
#pragma once

#include "tetraction/core/number_range.h"

namespace tetraction {

/// The range of each coefficient.
inline constexpr NumberRange kDampingRange{.least = 0.0,
                                           .advice = ": negative damping makes energy"};

/// The coefficients of the dissipative forces, all 0 or more. Each force is the derivative of a
/// dissipation potential.
struct Damping {
  double drag = 0.0;          ///< k_D: force −k_D v on every vertex, kg/s
  double mass_damping = 0.0;  ///< a: force −a M v, 1/s
  double viscosity = 0.0;     ///< η: second Piola stress 2ηĖ, Pa s (fem/viscous_potential.h)

  bool none() const { return drag == 0.0 && mass_damping == 0.0 && viscosity == 0.0; }
};

}  // namespace tetraction
