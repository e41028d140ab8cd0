// How the parts of a body agree on the outcome of a step.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// Makes the outcomes of all parts one: the shares in energies, work and impulses are added up, and if the
/// step of a part failed, that of all has failed for the same reason. balance_sums, of the same size in all
/// parts, goes into the same message between the processes. The failed element stays with the
/// part that has it, as the first of those that failed; others have −1. The solver's report and
/// residual_angular_impulse are those of the whole body already. Does nothing without a part.
void make_common(const MeshPart* part, StepOutcome& outcome);

/// a·b over the own vertices (3 per vertex), also of expressions.
template <class A, class B>
double own_dot(const MechanicalSystem& system, const Eigen::MatrixBase<A>& a,
               const Eigen::MatrixBase<B>& b) {
  if (system.part() == nullptr) return a.dot(b);
  const Index size = 3 * system.owned_vertex_count();
  return a.head(size).dot(b.head(size));
}

}  // namespace tetraction
