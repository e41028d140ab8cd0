#include "tetraction/dynamics/balance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tetraction/dynamics/body_sums.h"

namespace tetraction {

Balance::Balance(const MechanicalSystem& system, const State& state) : system_(system) {
  sums_.momenta = momenta_of(system, state);
  evaluate_energies(system, state, sums_.energies);
  // Strains below about 1e-13 are mere round-off.
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const LameParameters lame = system.lame(e);
    sums_.round_off += 1e-26 * (std::abs(lame.lambda) + 2.0 * lame.mu) * system.rest().volume(e);
  }
  sums_.round_off = sum_over_parts(system.part(), sums_.round_off);
  sums_.initial_energies = sums_.energies;
  sums_.initial_momenta = sums_.momenta;
  sums_.linear_scale = sums_.momenta.linear_scale;
  sums_.angular_scale = sums_.momenta.angular_scale;
}

void Balance::begin_step() {
  for (ObstacleImpulse& obstacle : sums_.obstacles) obstacle.in_step = {};
}

void Balance::enter(const State& state, const StepOutcome& outcome) {
  BalanceSums& s = sums_;
  entering_ = s.energies;
  Momenta momenta;
  double springs = 0.0;
  // May throw what a force term throws.
  vertex_balance(system_, state, entering_, momenta, springs, outcome.balance_sums);
  entering_.set_elastic(outcome.elastic_energy);
  std::swap(s.energies, entering_);
  s.momenta = momenta;
  s.external_work += outcome.external_work;
  s.dissipated_energy += outcome.dissipated_energy;
  s.constraint_work += outcome.constraint_work;
  s.friction_dissipation += outcome.friction_dissipation;
  s.obstacles.resize(std::max(s.obstacles.size(), outcome.obstacle_impulses.size()));
  for (std::size_t i = 0; i < outcome.obstacle_impulses.size(); ++i) {
    const ObstacleForce& impulse = outcome.obstacle_impulses[i];
    s.obstacles[i].linear += impulse.force;
    s.obstacles[i].angular += impulse.moment;
    s.obstacles[i].in_step.force += impulse.force;
    s.obstacles[i].in_step.moment += impulse.moment;
    s.obstacles[i].largest_force =
        std::max(s.obstacles[i].largest_force, impulse.force.norm() / outcome.step_size);
  }
  s.linear_impulse += outcome.linear_impulse;
  s.angular_impulse += outcome.angular_impulse;
  s.residual_angular_impulse += outcome.residual_angular_impulse;

  s.largest_allowed_residual = std::max(s.largest_allowed_residual, outcome.minimizer.asked_limit);
  if (outcome.minimizer.limited_by_round_off()) {
    ++s.limited_steps;
    s.largest_limited_residual = std::max(s.largest_limited_residual, outcome.minimizer.residual);
  }

  double exchange = std::abs(s.energies.environment() - s.initial_energies.environment());
  for (std::size_t i = 0; i < s.energies.extra_count(); ++i) {
    exchange += std::abs(s.energies.extra(i).value - s.initial_energies.extra(i).value);
  }
  s.largest_environment_exchange = std::max(s.largest_environment_exchange, exchange);
  s.largest_external_work = std::max(s.largest_external_work, std::abs(s.external_work));
  s.largest_constraint_work = std::max(s.largest_constraint_work, std::abs(s.constraint_work));
  s.largest_spring_energy = std::max(s.largest_spring_energy, springs);
  s.largest_energy_error = std::max(s.largest_energy_error, std::abs(energy_error()));
  s.largest_linear_drift =
      std::max(s.largest_linear_drift,
               (s.momenta.linear - s.initial_momenta.linear - s.linear_impulse).norm());
  s.largest_angular_drift =
      std::max(s.largest_angular_drift,
               (s.momenta.angular - s.initial_momenta.angular - s.angular_impulse).norm());
  // Impulses count, too, because a body that should have moved and did not has a drift. In a body that is held,
  // the impulses of loads and reactions cancel up to their round-off.
  s.linear_scale = std::max(
      {s.linear_scale, s.momenta.linear_scale, s.linear_impulse.norm(), outcome.impulse_size});
  s.angular_scale = std::max({s.angular_scale, s.momenta.angular_scale, s.angular_impulse.norm(),
                              outcome.angular_impulse_size});
}

double Balance::enter_edit(const State& state) {
  const Energies before = sums_.energies;
  const Momenta momenta_before = sums_.momenta;
  Energies energies = sums_.energies;
  evaluate_energies(system_, state, energies);  // may throw what a user's own material throws
  sums_.momenta = momenta_of(system_, state);
  sums_.energies = std::move(energies);
  // The jump is summed term by term, so that a large energy that did not change costs no digits.
  double jump = 0.0;
  for (std::size_t i = 0; i < sums_.energies.entries().size(); ++i) {
    jump += sums_.energies.entries()[i].value - before.entries()[i].value;
  }
  sums_.edit_work += jump;
  sums_.sum_of_edits += std::abs(jump);
  sums_.linear_impulse += sums_.momenta.linear - momenta_before.linear;
  sums_.angular_impulse += sums_.momenta.angular - momenta_before.angular;
  sums_.linear_scale = std::max(sums_.linear_scale, sums_.momenta.linear_scale);
  sums_.angular_scale = std::max(sums_.angular_scale, sums_.momenta.angular_scale);
  return jump;
}

// Formula (20) of docs/theory.md.
double Balance::energy_error() const {
  return sums_.energies.total() - sums_.initial_energies.total() - sums_.external_work +
         dissipated_energy() + friction_dissipation() - constraint_work() - edit_work();
}

double Balance::energy_scale() const {
  return sums_.initial_energies.kinetic() + std::abs(sums_.initial_energies.elastic()) +
         sums_.largest_environment_exchange + sums_.largest_external_work +
         sums_.largest_constraint_work + sums_.largest_spring_energy + sums_.sum_of_edits;
}

double Balance::max_relative_energy_drift() const {
  const double scale = std::max(energy_scale(), sums_.round_off);
  return scale > 0.0 ? sums_.largest_energy_error / scale : 0.0;
}

double Balance::linear_momentum_drift() const {
  return sums_.linear_scale > 0.0 ? sums_.largest_linear_drift / sums_.linear_scale : 0.0;
}

double Balance::angular_momentum_drift() const {
  return sums_.angular_scale > 0.0 ? sums_.largest_angular_drift / sums_.angular_scale : 0.0;
}

double Balance::allowed_angular_momentum_drift() const {
  return sums_.angular_scale > 0.0 ? sums_.residual_angular_impulse / sums_.angular_scale : 0.0;
}

}  // namespace tetraction
