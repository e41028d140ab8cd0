// The balance of energy and momentum of a run: every joule and every newton-second is accounted for.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/stepper.h"

namespace tetraction {

/// Balance of one trajectory, kept from its first state on; all sums run from there.
///
///     energy_error = ΔT + ΔW − external work + dissipated energy − constraint work − edit work
///
/// is what the integrator itself added (without loads: its energy error). The energy of penalty
/// springs counts as constraint work. The momentum drifts are
/// what is left of Δp and Δ(q × p) after the impulses of all outer forces and reactions.
class Balance {
 public:
  /// Opens the balance at `state`.
  Balance(const MechanicalSystem& system, const State& state);

  /// Enters a step that went well; `state` is the state after it.
  void enter(const State& state, const StepOutcome& outcome);

  /// Enters an edit of the state or the system between two steps: the jumps of energy and momenta
  /// are its work and its impulses. Returns the jump of the energy, J.
  double enter_edit(const State& state);

  const Energies& energies() const { return energies_; }
  const Momenta& momenta() const { return momenta_; }
  double external_work() const { return external_work_; }
  double dissipated_energy() const { return dissipated_energy_; }
  double constraint_work() const { return constraint_work_; }
  double edit_work() const { return edit_work_; }
  double energy_error() const;

  /// Energy that has entered the body: what it began with (kinetic and elastic) and the largest
  /// magnitudes of what environment, user forces and moving constraints gave it, and all edits, J.
  /// Energy drifts are relative to it.
  double energy_scale() const;
  /// Largest |energy_error| so far over energy_scale(), or over what round-off is worth where that is
  /// more.
  double max_relative_energy_drift() const;
  /// Largest |Δp − impulses| so far, over the largest Σ|p_i|; 0 for a body that never moved.
  double linear_momentum_drift() const;
  /// The same of angular momentum about the origin, over the largest Σ|q_i × p_i|.
  double angular_momentum_drift() const;
  /// The part of angular_momentum_drift() that the solver's remaining residuals allow:
  /// Σ over steps of their angular impulse (StepOutcome), over the same scale.
  double allowed_angular_momentum_drift() const;

  /// Implicit steps that are as good as double precision allows but not as good as the tolerance asks
  /// for.
  Index steps_limited_by_round_off() const { return limited_steps_; }
  /// The largest residual that such a step was left with, over the largest residual that the tolerance
  /// allowed in any step; 0 without such steps. Above 1 the tolerance has not been reached.
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
