// The step-size limit of the explicit rules.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Largest eigenfrequency of the linearised system and the step it allows.
struct StabilityLimit {
  double omega_max = 0.0;      ///< rad/s, √λ_max of M⁻¹K(q) over the free DOFs
  double critical_step = 0.0;  ///< h_crit = 2/ω_max, s
  Index element = -1;          ///< element that moves most in that eigenmode (internal number)
};

/// h_crit = 2/ω_max at positions q by Lanczos iterations on the matrix-free K (Spectra), to a
/// relative accuracy of 1e-4 in ω². W must be defined at q.
/// If K(q) has no positive eigenvalue, omega_max is 0 and critical_step infinite.
StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q);

}  // namespace tetraction
