// Where the contact of a session with obstacles is evaluated.
#pragma once

#include "tetraction/simulation/session.h"

namespace tetraction {

/// At a state of the session. An equilibrium has the load factor as its time, and moves obstacles with it. The point
/// refers to the positions of `state`.
inline ForcePoint contact_point(const Session& session, const State& state) {
  const bool is_static = session.load_path() != nullptr;
  ForcePoint at = session.system().force_point(state.position, is_static ? 0.0 : state.time);
  if (is_static) at.load_factor = state.time;
  return at;
}

}  // namespace tetraction
