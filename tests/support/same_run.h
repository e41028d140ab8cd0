// Comparisons of runs bit by bit.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::testing_support {

/// All numbers of a balance.
inline std::vector<double> numbers_of(const BalanceSums& sums) {
  std::vector<double> numbers;
  for (const Energies* energies : {&sums.initial_energies, &sums.energies}) {
    for (const Energies::Entry& entry : energies->entries()) numbers.push_back(entry.value);
  }
  for (const Momenta* momenta : {&sums.initial_momenta, &sums.momenta}) {
    for (Index i = 0; i < 3; ++i) {
      numbers.push_back(momenta->linear[i]);
      numbers.push_back(momenta->angular[i]);
    }
    numbers.push_back(momenta->linear_scale);
    numbers.push_back(momenta->angular_scale);
  }
  for (Index i = 0; i < 3; ++i) {
    numbers.push_back(sums.linear_impulse[i]);
    numbers.push_back(sums.angular_impulse[i]);
  }
  for (const double number :
       {sums.external_work, sums.dissipated_energy, sums.constraint_work, sums.edit_work,
        sums.residual_angular_impulse, sums.round_off, sums.largest_environment_exchange,
        sums.largest_external_work, sums.largest_constraint_work, sums.largest_spring_energy,
        sums.sum_of_edits, sums.largest_energy_error, sums.largest_linear_drift,
        sums.largest_angular_drift, sums.linear_scale, sums.angular_scale,
        static_cast<double>(sums.limited_steps), sums.largest_limited_residual,
        sums.largest_allowed_residual}) {
    numbers.push_back(number);
  }
  numbers.push_back(sums.friction_dissipation);
  for (const ObstacleImpulse& obstacle : sums.obstacles) {
    for (Index i = 0; i < 3; ++i) {
      numbers.push_back(obstacle.linear[i]);
      numbers.push_back(obstacle.angular[i]);
    }
    numbers.push_back(obstacle.largest_force);
  }
  return numbers;
}

/// Expects that both sessions are at the same point of the same run.
inline void expect_same(const Session& a, const Session& b) {
  EXPECT_EQ(a.state().step, b.state().step);
  EXPECT_EQ(a.state().time, b.state().time);
  EXPECT_EQ(a.state().position, b.state().position);
  EXPECT_EQ(a.state().momentum, b.state().momentum);
  EXPECT_EQ(a.state().velocity, b.state().velocity);
  EXPECT_EQ(numbers_of(a.balance().sums()), numbers_of(b.balance().sums()));
  EXPECT_EQ(a.status(), b.status());
  EXPECT_EQ(a.message(), b.message());
  EXPECT_EQ(a.time_step(), b.time_step());
  EXPECT_EQ(a.step_count(), b.step_count());
  EXPECT_EQ(a.steps().changes, b.steps().changes);
  EXPECT_EQ(a.steps().smallest, b.steps().smallest);
  EXPECT_EQ(a.warnings(), b.warnings());
  EXPECT_EQ(a.edits().size(), b.edits().size());
  EXPECT_EQ(a.reaction_force(), b.reaction_force());
  EXPECT_EQ(a.external_force(), b.external_force());
  EXPECT_EQ(a.total_iterations(), b.total_iterations());
  EXPECT_EQ(a.total_factorizations(), b.total_factorizations());
  EXPECT_EQ(a.total_cg_iterations(), b.total_cg_iterations());
  EXPECT_EQ(a.linear_solver(), b.linear_solver());
  EXPECT_EQ(a.inverted_elements().most, b.inverted_elements().most);
  ASSERT_EQ(a.constraints().size(), b.constraints().size());
  for (std::size_t i = 0; i < a.constraints().size(); ++i) EXPECT_EQ(a.tension(i), b.tension(i));
}

}  // namespace tetraction::testing_support
