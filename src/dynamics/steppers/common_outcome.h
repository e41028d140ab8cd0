// The outcome of a step, which all parts of a body have in common.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// Makes the outcomes of all parts one: the shares in energies, work and impulses are added up, and if the
/// step of a part failed, that of all has failed for the same reason. balance_sums, of the same size in all
/// parts, goes into the same message between the processes. The failed element stays with the
/// part that has it, as the first of those that failed; others have −1. The solver's report and
/// residual_angular_impulse are those of the whole body already. Does nothing without a part.
void make_common(const MeshPart* part, StepOutcome& outcome);

/// Adds the impulse of a vertex at x to the sums of a step.
inline void enter_impulse(const Vector3& x, const Vector3& impulse, StepOutcome& outcome) {
  const Vector3 angular = x.cross(impulse);
  outcome.linear_impulse += impulse;
  outcome.angular_impulse += angular;
  outcome.impulse_size += impulse.lpNorm<1>();
  outcome.angular_impulse_size += angular.lpNorm<1>();
}

/// Whether the energies and impulses that a step enters into the balance are finite.
inline bool has_finite_balance(const StepOutcome& outcome) {
  return std::isfinite(outcome.elastic_energy) && std::isfinite(outcome.external_work) &&
         std::isfinite(outcome.dissipated_energy) && std::isfinite(outcome.constraint_work) &&
         outcome.linear_impulse.allFinite() && outcome.angular_impulse.allFinite();
}

}  // namespace tetraction
