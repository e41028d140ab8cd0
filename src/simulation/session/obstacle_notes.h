// How obstacles keep a step from its end.
#pragma once

#include <optional>
#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/state.h"

namespace tetraction {

/// How obstacles keep a step from its end, and what to do.
struct ObstacleNote {
  std::string what;    ///< one clause
  std::string remedy;  ///< whole sentences
};

/// Looks for an obstacle that makes a step from `from` impossible: one into which vertices are led that cannot give way,
/// one that moves by more than half of an element, some that crush the body, or one that `attempted` penetrates or has
/// passed (empty: not known). `end` is the time at the end of the step, or the load factor of an equilibrium, and
/// `prescribed` the positions of `from` with those that are prescribed there. Positions: 3 per vertex, m.
std::optional<ObstacleNote> obstacle_note(const MechanicalSystem& system, const State& from,
                                          double end, const Vector& prescribed,
                                          const Vector& attempted, bool is_static);

}  // namespace tetraction
