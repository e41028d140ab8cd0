#include "tetraction/dynamics/balance.h"

#include <algorithm>
#include <cmath>

namespace tetraction {

Balance::Balance(const MechanicalSystem& system, const State& state)
    : system_(system), momenta_(system.momenta(state)) {
  system.energies(state, energies_);
  // Strains below about 1e-13 are mere round-off.
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const LameParameters lame = system.elastic().lame(e);
    round_off_ += 1e-26 * (std::abs(lame.lambda) + 2.0 * lame.mu) * system.rest().volume(e);
  }
  initial_energies_ = energies_;
  initial_momenta_ = momenta_;
  linear_scale_ = momenta_.linear_scale;
  angular_scale_ = momenta_.angular_scale;
}

void Balance::enter(const State& state, const StepOutcome& outcome) {
  system_.vertex_balance(state, energies_, momenta_);
  energies_.set_elastic(outcome.elastic_energy);
  external_work_ += outcome.external_work;
  dissipated_energy_ += outcome.dissipated_energy;
  constraint_work_ += outcome.constraint_work;
  linear_impulse_ += outcome.linear_impulse;
  angular_impulse_ += outcome.angular_impulse;
  residual_angular_impulse_ += outcome.residual_angular_impulse;

  largest_allowed_residual_ = std::max(largest_allowed_residual_, outcome.minimizer.asked_limit);
  if (outcome.minimizer.limited_by_round_off()) {
    ++limited_steps_;
    largest_limited_residual_ = std::max(largest_limited_residual_, outcome.minimizer.residual);
  }

  double exchange = std::abs(energies_.environment() - initial_energies_.environment());
  for (std::size_t i = 0; i < energies_.extra_count(); ++i) {
    exchange += std::abs(energies_.extra(i).value - initial_energies_.extra(i).value);
  }
  largest_environment_exchange_ = std::max(largest_environment_exchange_, exchange);
  largest_external_work_ = std::max(largest_external_work_, std::abs(external_work_));
  largest_constraint_work_ = std::max(largest_constraint_work_, std::abs(constraint_work_));
  largest_energy_error_ = std::max(largest_energy_error_, std::abs(energy_error()));
  largest_linear_drift_ = std::max(
      largest_linear_drift_, (momenta_.linear - initial_momenta_.linear - linear_impulse_).norm());
  largest_angular_drift_ =
      std::max(largest_angular_drift_,
               (momenta_.angular - initial_momenta_.angular - angular_impulse_).norm());
  // Impulses count, too, because a body that should have moved and did not has a drift.
  linear_scale_ = std::max({linear_scale_, momenta_.linear_scale, linear_impulse_.norm()});
  angular_scale_ = std::max({angular_scale_, momenta_.angular_scale, angular_impulse_.norm()});
}

double Balance::enter_edit(const State& state) {
  const Energies before = energies_;
  const Momenta momenta_before = momenta_;
  Energies energies = energies_;
  system_.energies(state, energies);  // may throw what a user's own material throws
  energies_ = energies;
  momenta_ = system_.momenta(state);
  // The jump is summed term by term, so that a large energy that did not change costs no digits.
  double jump = 0.0;
  for (std::size_t i = 0; i < energies_.entries().size(); ++i) {
    jump += energies_.entries()[i].value - before.entries()[i].value;
  }
  edit_work_ += jump;
  sum_of_edits_ += std::abs(jump);
  linear_impulse_ += momenta_.linear - momenta_before.linear;
  angular_impulse_ += momenta_.angular - momenta_before.angular;
  linear_scale_ = std::max(linear_scale_, momenta_.linear_scale);
  angular_scale_ = std::max(angular_scale_, momenta_.angular_scale);
  return jump;
}

double Balance::energy_error() const {
  return energies_.total() - initial_energies_.total() - external_work_ + dissipated_energy() -
         constraint_work() - edit_work();
}

double Balance::energy_scale() const {
  return initial_energies_.kinetic() + std::abs(initial_energies_.elastic()) +
         largest_environment_exchange_ + largest_external_work_ + largest_constraint_work_ +
         sum_of_edits_;
}

double Balance::max_relative_energy_drift() const {
  const double scale = std::max(energy_scale(), round_off_);
  return scale > 0.0 ? largest_energy_error_ / scale : 0.0;
}

double Balance::linear_momentum_drift() const {
  return linear_scale_ > 0.0 ? largest_linear_drift_ / linear_scale_ : 0.0;
}

double Balance::angular_momentum_drift() const {
  return angular_scale_ > 0.0 ? largest_angular_drift_ / angular_scale_ : 0.0;
}

double Balance::allowed_angular_momentum_drift() const {
  return angular_scale_ > 0.0 ? residual_angular_impulse_ / angular_scale_ : 0.0;
}

}  // namespace tetraction
