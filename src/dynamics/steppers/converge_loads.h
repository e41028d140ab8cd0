// Loads that depend on the positions that they lead to.
#pragma once

#include "core/anderson_mixing.h"
#include "tetraction/core/types.h"

namespace tetraction {

enum class LoadConvergence {
  kConverged,
  kNotConverged,  ///< the loads still changed after the last round, or became infinite
  kNotSolved      ///< a solution with given loads failed
};

/// Replaces `load` by that of the solution until both agree. Anderson's acceleration chooses the loads
/// of each round. `load_of_solution(Vector&)` returns the loads at the last solution,
/// `is_small(change, load)` says whether they are those of the solution, and `solve_with(load)` finds the
/// solution with given loads and returns whether there is one.
template <class LoadOfSolution, class IsSmall, class SolveWith>
LoadConvergence converge_loads(Vector& load, LoadOfSolution&& load_of_solution, IsSmall&& is_small,
                               SolveWith&& solve_with) {
  constexpr int kRounds = 60;
  AndersonMixing mixing;
  Vector present;
  Vector change;
  for (int round = 0; round < kRounds; ++round) {
    load_of_solution(present);
    change = present - load;
    if (is_small(change, present)) return LoadConvergence::kConverged;
    if (!change.allFinite()) break;
    load = mixing.next(load, present);
    if (!solve_with(load)) return LoadConvergence::kNotSolved;
  }
  return LoadConvergence::kNotConverged;
}

}  // namespace tetraction
