// From a session to what the window draws.
#pragma once

#include <cstdint>
#include <vector>

#include "snapshot.h"

namespace tetraction::viewer {

/// Fills the parts of a snapshot that the session knows: time, state, forces, held vertices, colours.
Snapshot make_snapshot(const Session& session, ColorField field);

}  // namespace tetraction::viewer
