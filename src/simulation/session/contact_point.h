// Where the contact of a session with obstacles is evaluated.
#pragma once

#include "tetraction/simulation/session.h"

namespace tetraction {

/// At a state of the session. An equilibrium has the load factor as its time, and moves obstacles with it. The point
/// refers to the positions of `state`.
inline ForcePoint contact_point(const MechanicalSystem& system, const State& state,
                                bool is_static) {
  ForcePoint at = system.force_point(state.position, is_static ? 0.0 : state.time);
  if (is_static) at.load_factor = state.time;
  return at;
}
inline ForcePoint contact_point(const Session& session, const State& state) {
  return contact_point(session.system(), state, session.load_path() != nullptr);
}

}  // namespace tetraction
