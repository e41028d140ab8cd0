// The positions about which the body of a scene vibrates.
#pragma once

#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {

/// Positions for normal_modes(), with what belongs to them.
struct PositionsOfModes {
  bool found = true;    ///< false if there is no equilibrium
  Vector position;      ///< 3 per vertex, m; empty if there is none
  std::string message;  ///< why there is none, or what is to be told of it; empty: nothing
  NormalModeOptions options;
};

/// Sets the constraints of a scene's body and returns where it vibrates: about the undeformed body, or,
/// if `loaded`, about the equilibrium under the loads at t = 0 (find_equilibrium()). Prescribed
/// displacements then grow with the load factor, as in `tetraction static`. Throws InputError as
/// make_initial_state() and find_equilibrium() do.
PositionsOfModes positions_of_modes(const Scene& scene, MechanicalSystem& system, bool loaded,
                                    Index count);

}  // namespace tetraction
