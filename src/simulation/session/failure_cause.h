// The cause of a failed step, and its remedy.
#pragma once

#include <optional>
#include <string>

#include "simulation/stepping/run_data.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

/// The cause of a failure, of which the place is known.
FailureCause cause_of(const RunData& run, const StepOutcome& outcome, const StepFailure& failure);

/// The remedy for the user. `advice`: StepStrategy::advice().
std::string remedy_for(const RunData& run, const StepFailure& failure, const StepOutcome& outcome,
                       const std::string& advice);

/// Whether prescribed motion leads vertices at that time to where positions are not finite.
bool leads_out_of_range(const MechanicalSystem& system, const State& from, double time);

/// How obstacles keep a step from its end, and what to do.
struct ObstacleNote {
  std::string what;    ///< one clause
  std::string remedy;  ///< whole sentences
};

/// Looks for an obstacle that makes a step from `from` impossible: one into which vertices are led that cannot give way,
/// one that moves by more than half of an element, or one that `attempted` penetrates or has passed (empty: not
/// known). `end` is the time at the end of the step, or the load factor of an equilibrium, and `prescribed` the
/// positions of `from` with those that are prescribed there. Positions: 3 per vertex, m.
std::optional<ObstacleNote> obstacle_note(const MechanicalSystem& system, const State& from,
                                          double end, const Vector& prescribed,
                                          const Vector& attempted, bool is_static);

/// A term and a vertex whose force is not a finite number.
struct BadForce {
  std::string term;
  Index vertex = 0;
};

/// The first one, if there is one.
std::optional<BadForce> bad_force(const MechanicalSystem& system, const ForcePoint& at);

}  // namespace tetraction
