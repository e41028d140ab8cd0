// From a session to what the window draws.
#pragma once

#include <cstdint>
#include <vector>

#include "snapshot.h"

namespace tetraction::viewer {

/// Fills the parts of a snapshot that the session knows: time, state, forces, held vertices, colours.
Snapshot make_snapshot(const Session& session, ColorField field);

/// Per vertex: 1 where a [[fix]] or the mouse holds it.
std::vector<std::uint8_t> held_vertices(const Session& session);

}  // namespace tetraction::viewer
