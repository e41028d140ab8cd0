// The outcome of a step, which all parts of a body have in common.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// Makes the outcomes of all parts one: the shares in energies, work and impulses are added up, and if the
/// step of a part failed, that of all has failed for the same reason. balance_sums, of the same size in all
/// parts, goes into the same message between the processes. The failed element stays with the
/// part that has it, as the first of those that failed; others have −1. The solver's report and
/// residual_angular_impulse are those of the whole body already. Does nothing without a part.
void make_common(const MeshPart* part, StepOutcome& outcome);

/// The sums of impulses of a step. They begin with those of an outcome and replace them at the end. Sums of their own, to
/// which nothing else refers, stay in registers while a loop adds to them.
struct ImpulseSums {
  Vector3 linear;
  Vector3 angular;
  double size;
  double angular_size;

  explicit ImpulseSums(const StepOutcome& outcome)
      : linear(outcome.linear_impulse),
        angular(outcome.angular_impulse),
        size(outcome.impulse_size),
        angular_size(outcome.angular_impulse_size) {}
  void add(const Vector3& impulse, const Vector3& moment) {
    linear += impulse;
    angular += moment;
    size += impulse.lpNorm<1>();
    angular_size += moment.lpNorm<1>();
  }
  /// Adds the impulse of a vertex at x.
  void add_at(const Vector3& x, const Vector3& impulse) { add(impulse, x.cross(impulse)); }
  void enter(StepOutcome& outcome) const {
    outcome.linear_impulse = linear;
    outcome.angular_impulse = angular;
    outcome.impulse_size = size;
    outcome.angular_impulse_size = angular_size;
  }
};

/// Enters the impulses of obstacles that act with these forces for the time dt.
inline void enter_obstacle_impulses(const std::vector<ObstacleForce>& forces, double dt,
                                    StepOutcome& outcome) {
  outcome.obstacle_impulses.resize(forces.size());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    outcome.obstacle_impulses[i].force += dt * forces[i].force;
    outcome.obstacle_impulses[i].moment += dt * forces[i].moment;
  }
}

/// Makes the outcome that of a step which has not failed.
inline void forget_failure(StepOutcome& outcome) {
  outcome.status = StepStatus::kOk;
  outcome.message.clear();
  outcome.obstacle = StepObstacle::kSolver;
}

/// Whether the energies and impulses that a step enters into the balance are finite.
inline bool has_finite_balance(const StepOutcome& outcome) {
  return std::isfinite(outcome.elastic_energy) && std::isfinite(outcome.external_work) &&
         std::isfinite(outcome.dissipated_energy) && std::isfinite(outcome.constraint_work) &&
         std::isfinite(outcome.friction_dissipation) && outcome.linear_impulse.allFinite() &&
         outcome.angular_impulse.allFinite();
}

}  // namespace tetraction
