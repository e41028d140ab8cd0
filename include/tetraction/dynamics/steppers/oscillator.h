// The effect of the time-stepping rules on one mode of vibration.
#pragma once

#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction {

/// A rule's answer to free vibrations of the undamped oscillator ü + ω²u = 0.
struct OscillatorResponse {
  /// Whether the amplitude stays bounded. Nothing else has a meaning if it does not.
  bool is_stable = true;
  /// Numerical period over exact period, minus 1.
  double period_error = 0.0;
  /// Algorithmic damping: the ζ of a damped oscillator whose free vibrations decay as those of the
  /// rule do, ζ = −ln(r)/θ with the factor r of the amplitude and the phase angle θ of a step.
  double damping_ratio = 0.0;
  /// Share of the amplitude that is left after one numerical period, r^(2π/θ).
  double amplitude_left = 1.0;
};

/// The response of a rule with steps of size h, for ωh > 0: table (35) of docs/theory.md. The numerical period
/// is 2πh/θ (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, I.1 and I.5).
OscillatorResponse oscillator_response(Integrator rule, double omega_h);

/// The largest ωh up to which a rule is stable, its period error has a magnitude of at most
/// `period_error`, and at most the share `loss` of the amplitude is lost in a period. Both are
/// between 0 and 1, both excluded.
double resolved_omega_h(Integrator rule, double period_error, double loss);

}  // namespace tetraction
