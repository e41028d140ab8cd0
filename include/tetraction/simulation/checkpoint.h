// Everything that a run needs to go on from one of its states, bit by bit.
#pragma once

#include <cstdint>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/reactions.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/simulation/run_progress.h"
#include "tetraction/simulation/run_settings.h"

namespace tetraction {

/// Tells bodies apart. Each part is a number made from what it is named after, so that a message can
/// say which one differs.
struct BodyIdentity {
  std::uint64_t mesh = 0;         ///< positions at rest, tetrahedra and their order
  std::uint64_t regions = 0;      ///< the region of each tetrahedron
  std::uint64_t densities = 0;    ///< the density of each region
  std::uint64_t force_terms = 0;  ///< the names of the force terms, in their order

  bool operator==(const BodyIdentity&) const = default;
};

/// A run at one of its states, as plain data. Session::checkpoint() makes it, and Session::restore()
/// goes on from it.
///
/// It contains neither the scene nor the mesh: a session of the same scene and mesh has them. Objects
/// of the program (custom materials, force fields) are shared with the session, not copied; force
/// terms belong to the scene. Times of PhaseTimes are those of a session and not in it.
struct Checkpoint {
  BodyIdentity body;
  RunSettings settings;
  RunProgress progress;
  State state;
  BalanceSums balance;
  Reactions reactions;
};

}  // namespace tetraction
