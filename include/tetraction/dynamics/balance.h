// The balance of energy and momentum of a run. It accounts for every joule and every newton-second.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {

/// Balance of one trajectory. All sums begin with its first state.
///
///     energy_error = ΔT + ΔW − external work + dissipated energy − constraint work − edit work
///
/// is the energy that the integrator itself added. The energy of penalty springs counts as
/// constraint work. The momentum drifts are Δp and Δ(q × p) less the impulses of all outer forces
/// and reactions.
class Balance {
 public:
  /// Opens the balance at `state`.
  Balance(const MechanicalSystem& system, const State& state);

  /// Enters a successful step. `state` is the state after it.
  void enter(const State& state, const StepOutcome& outcome);

  /// Enters an edit of the state or the system between two steps. The jumps of energy and momenta
  /// count as its work and its impulses. Returns the jump of the energy, J.
  double enter_edit(const State& state);

  const Energies& energies() const { return energies_; }
  const Momenta& momenta() const { return momenta_; }
  double external_work() const { return external_work_; }
  double dissipated_energy() const { return dissipated_energy_; }
  double constraint_work() const { return constraint_work_; }
  double edit_work() const { return edit_work_; }
  double energy_error() const;

  /// The energy that has entered the body, J. It is the sum of the kinetic and elastic energy at
  /// the beginning, the largest magnitudes so far of what environment, user forces and moving
  /// constraints gave the body, and the magnitudes of all edits. Energy drifts are relative to it.
  double energy_scale() const;
  /// Largest |energy_error| so far, divided by energy_scale() or by the energy of round-off,
  /// whichever is larger.
  double max_relative_energy_drift() const;
  /// Largest |Δp − impulses| so far, divided by the largest Σ|p_i| or sum of impulses so far; 0 for
  /// a body that never moved.
  double linear_momentum_drift() const;
  /// Largest |Δ(q × p) − angular impulses| about the origin so far, divided by the largest Σ|q_i ×
  /// p_i|.
  double angular_momentum_drift() const;
  /// The part of angular_momentum_drift() that the solver's remaining residuals explain: the sum
  /// over all steps of their angular impulse (StepOutcome), divided by the same scale.
  double allowed_angular_momentum_drift() const;

  /// The number of implicit steps that are as exact as double precision allows, but less exact than
  /// the tolerance demands.
  Index steps_limited_by_round_off() const { return limited_steps_; }
  /// The largest remaining residual of such a step, divided by the largest residual that the
  /// tolerance allowed in any step; 0 without such steps. Above 1 the tolerance has not been
  /// reached.
  double residual_over_tolerance() const {
    return largest_allowed_residual_ > 0.0 ? largest_limited_residual_ / largest_allowed_residual_
                                           : 0.0;
  }

 private:
  const MechanicalSystem& system_;
  Energies initial_energies_;
  Energies energies_;
  Momenta initial_momenta_;
  Momenta momenta_;
  double external_work_ = 0.0;
  double dissipated_energy_ = 0.0;
  double constraint_work_ = 0.0;
  double edit_work_ = 0.0;
  Vector3 linear_impulse_ = Vector3::Zero();
  Vector3 angular_impulse_ = Vector3::Zero();
  double residual_angular_impulse_ = 0.0;
  double largest_environment_exchange_ = 0.0;
  double round_off_ = 0.0;
  double largest_external_work_ = 0.0;
  double largest_constraint_work_ = 0.0;
  double sum_of_edits_ = 0.0;
  double largest_energy_error_ = 0.0;
  double largest_linear_drift_ = 0.0;
  double largest_angular_drift_ = 0.0;
  double linear_scale_ = 0.0;
  double angular_scale_ = 0.0;
  Index limited_steps_ = 0;
  double largest_limited_residual_ = 0.0;
  double largest_allowed_residual_ = 0.0;
};

}  // namespace tetraction
