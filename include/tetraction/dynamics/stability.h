// The step-size limit of the explicit rules.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// Largest eigenfrequency of the linearised system and the step it allows.
struct StabilityLimit {
  double omega_max = 0.0;     ///< rad/s, √λ_max of M⁻¹K(q) over the free coordinates
  double damping_rate = 0.0;  ///< c, 1/s: λ_max of M⁻¹C with the damping matrix C
  /// h_crit, s: 2/ω_max without damping, else the h of h²ω_max² + 2hc = 4.
  double critical_step = 0.0;
  Index element = -1;  ///< that moves most in that eigenmode (internal number); −1 without any
};

/// h_crit at positions q by Lanczos iterations (Spectra) on the matrix-free K, to a relative accuracy
/// of 1e-4 in ω². W must be defined at q. K holds elastic energy, environment and penalty springs;
/// multipliers are left out, which can only make the limit too small.
///
/// Damping that is taken at the beginning of the step lowers the limit: with one mode of frequency ω
/// and rate c, `explicit` is stable for h²ω² + 2hc < 4; ω_max and c may belong to different modes,
/// so the limit is on the safe side.
/// If K(q) has no positive eigenvalue, or every vertex is held, omega_max is 0; without damping
/// critical_step is then infinite. Throws InputError where K(q) over the masses is not finite.
StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q);

}  // namespace tetraction
