// What must be a finite number at the end of a step besides positions and momenta.
#pragma once

#include <cmath>

#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// Whether the energies and impulses that a step enters into the balance are finite.
inline bool has_finite_balance(const StepOutcome& outcome) {
  return std::isfinite(outcome.elastic_energy) && std::isfinite(outcome.external_work) &&
         std::isfinite(outcome.dissipated_energy) && std::isfinite(outcome.constraint_work) &&
         outcome.linear_impulse.allFinite() && outcome.angular_impulse.allFinite();
}

}  // namespace tetraction
