#include "tetraction/dynamics/steppers/oscillator.h"

#include <cmath>
#include <numbers>

namespace tetraction {

// The table (35) of docs/theory.md.
OscillatorResponse oscillator_response(Integrator rule, double omega_h) {
  OscillatorResponse response;
  double angle = 0.0;
  double decay = 0.0;  // −ln r
  switch (rule) {
    case Integrator::kExplicit:
    case Integrator::kVerlet:
      response.is_stable = omega_h < 2.0;
      if (!response.is_stable) return response;
      angle = 2.0 * std::asin(0.5 * omega_h);
      break;
    case Integrator::kMidpoint:
    case Integrator::kEnergyMomentum:
      angle = 2.0 * std::atan(0.5 * omega_h);
      break;
    case Integrator::kBackwardEuler:
      angle = std::atan(omega_h);
      decay = 0.5 * std::log1p(omega_h * omega_h);
      break;
  }
  response.period_error = omega_h / angle - 1.0;
  response.damping_ratio = decay / angle;
  response.amplitude_left = std::exp(-2.0 * std::numbers::pi * decay / angle);
  return response;
}

double resolved_omega_h(Integrator rule, double period_error, double loss) {
  const auto resolved = [&](double omega_h) {
    const OscillatorResponse response = oscillator_response(rule, omega_h);
    return response.is_stable && std::abs(response.period_error) <= period_error &&
           response.amplitude_left >= 1.0 - loss;
  };
  double low = 0.0;
  double high = 1.0;
  while (resolved(high)) high *= 2.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (resolved(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace tetraction
