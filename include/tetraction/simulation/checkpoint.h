// Everything that a run needs to go on from one of its states, bit by bit.
#pragma once

#include <cstdint>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/simulation/run_progress.h"
#include "tetraction/simulation/run_settings.h"

namespace tetraction {

/// A run at one of its states, as plain data. Session::checkpoint() makes it, and Session::restore()
/// goes on from it.
///
/// It contains neither the scene nor the mesh: a session of the same scene and mesh has them. Objects
/// of the program (custom materials, force fields) are shared with the session, not copied; force
/// terms belong to the scene. Times of PhaseTimes are those of a session and not in it.
struct Checkpoint {
  /// Tells bodies apart: a number made from the mesh, the densities and the names of the force terms.
  std::uint64_t body = 0;
  RunSettings settings;
  RunProgress progress;
  State state;
  BalanceSums balance;
  Vector reaction_force;       ///< Session::reaction_force(), N
  Vector configuration_force;  ///< Stepper::configuration_force()
};

}  // namespace tetraction
