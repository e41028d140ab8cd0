// The balance of energy and momentum of a run. It accounts for every joule and every newton-second.
#pragma once

#include <utility>
#include <vector>

#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"

namespace tetraction {

/// What an obstacle has done to the body.
struct ObstacleImpulse {
  Vector3 linear = Vector3::Zero();   ///< N s
  Vector3 angular = Vector3::Zero();  ///< about the origin, N m s
  double largest_force = 0.0;         ///< the largest mean force of a step, N
  ObstacleForce in_step;              ///< of the two impulses, since begin_step(), N s and N m s
};

/// The numbers of a balance as plain data. A balance that continues with them is the same balance.
struct BalanceSums {
  Energies initial_energies;                  ///< at the beginning, J
  Energies energies;                          ///< now
  Momenta initial_momenta;                    ///< at the beginning
  Momenta momenta;                            ///< now
  double external_work = 0.0;                 ///< J
  double dissipated_energy = 0.0;             ///< J
  double constraint_work = 0.0;               ///< J
  double friction_dissipation = 0.0;          ///< J
  std::vector<ObstacleImpulse> obstacles;     ///< in the order of the obstacles
  double edit_work = 0.0;                     ///< J
  Vector3 linear_impulse = Vector3::Zero();   ///< of outer forces, reactions and edits, N s
  Vector3 angular_impulse = Vector3::Zero();  ///< the same about the origin, N m s
  double residual_angular_impulse = 0.0;  ///< sum of StepOutcome::residual_angular_impulse, N m s
  double round_off = 0.0;                 ///< energy of strains that are mere round-off, J
  // The largest magnitudes so far.
  double largest_environment_exchange = 0.0;  ///< energy taken from potentials of force terms, J
  double largest_external_work = 0.0;         ///< J
  double largest_constraint_work = 0.0;       ///< J
  double largest_spring_energy = 0.0;         ///< of potentials that stand for constraints, J
  double sum_of_edits = 0.0;                  ///< sum of the magnitudes of the jumps of edits, J
  double largest_energy_error = 0.0;          ///< J
  double largest_linear_drift = 0.0;          ///< N s
  double largest_angular_drift = 0.0;         ///< N m s
  double linear_scale = 0.0;                  ///< kg m/s
  double angular_scale = 0.0;                 ///< kg m²/s
  // Implicit steps.
  Index limited_steps = 0;                ///< less exact than the tolerance demands
  double largest_limited_residual = 0.0;  ///< of such a step, N
  double largest_allowed_residual = 0.0;  ///< of any step, N
};

/// Balance of one trajectory. All sums begin with its first state.
///
///     energy_error = ΔT + ΔW − external work + dissipated energy + friction − constraint work − edit work
///
/// is the energy that the integrator itself added. The energy of penalty springs counts as
/// constraint work. The momentum drifts are Δp and Δ(q × p) less the impulses of all outer forces
/// and reactions.
class Balance {
 public:
  /// Opens the balance at `state`.
  Balance(const MechanicalSystem& system, const State& state);

  /// Begins a step, which may consist of several that are entered.
  void begin_step();
  /// Enters a successful step. `state` is the state after it. If a force term throws an exception,
  /// nothing has been entered.
  void enter(const State& state, const StepOutcome& outcome);

  /// Enters an edit of the state or the system between two steps. The jumps of energy and momenta
  /// count as its work and its impulses. Returns the jump of the energy, J.
  double enter_edit(const State& state);

  /// The numbers of the balance.
  const BalanceSums& sums() const { return sums_; }
  /// Continues with the numbers of an earlier time, or of another balance of the same body.
  void restore(BalanceSums sums) { sums_ = std::move(sums); }

  const Energies& energies() const { return sums_.energies; }
  const Momenta& momenta() const { return sums_.momenta; }
  double external_work() const { return sums_.external_work; }
  double dissipated_energy() const { return sums_.dissipated_energy; }
  double constraint_work() const { return sums_.constraint_work; }
  /// The heat of friction with obstacles, J.
  double friction_dissipation() const { return sums_.friction_dissipation; }
  double edit_work() const { return sums_.edit_work; }
  double energy_error() const;

  /// The energy that has entered the body, J. It is the sum of the kinetic and elastic energy at
  /// the beginning, the largest magnitudes so far of what environment, user forces and moving
  /// constraints gave the body and of the energy in penalty springs, and the magnitudes of all edits. Energy drifts are relative to it.
  double energy_scale() const;
  /// Largest |energy_error| so far, divided by energy_scale() or by the energy of round-off,
  /// whichever is larger.
  double max_relative_energy_drift() const;
  /// Largest |Δp − impulses| so far, divided by the largest Σ|p_i|, sum of impulses, or Σ|impulse| of all vertices in a
  /// step so far; 0 for a body that never moved and on which nothing acts.
  double linear_momentum_drift() const;
  /// Largest |Δ(q × p) − angular impulses| about the origin so far, divided by the largest Σ|q_i ×
  /// p_i| or the same of impulses.
  double angular_momentum_drift() const;
  /// The part of angular_momentum_drift() that the solver's remaining residuals explain: the sum
  /// over all steps of their angular impulse (StepOutcome), divided by the same scale.
  double allowed_angular_momentum_drift() const;

  /// The number of implicit steps that are as exact as double precision allows, but less exact than
  /// the tolerance demands.
  Index steps_limited_by_round_off() const { return sums_.limited_steps; }
  /// The largest remaining residual of such a step, divided by the largest residual that the
  /// tolerance allowed in any step; 0 without such steps. Above 1 the tolerance has not been
  /// reached.
  double residual_over_tolerance() const {
    return sums_.largest_allowed_residual > 0.0
               ? sums_.largest_limited_residual / sums_.largest_allowed_residual
               : 0.0;
  }

 private:
  const MechanicalSystem& system_;
  BalanceSums sums_;
  Energies entering_;  // work space of enter(), which must not allocate
};

}  // namespace tetraction
