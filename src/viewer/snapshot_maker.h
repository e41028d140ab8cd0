// Makes snapshots of a session.
#pragma once

#include <cstdint>
#include <vector>

#include "kept_states.h"
#include "snapshot.h"

namespace tetraction::viewer {

/// A snapshot with the data of the session: time, state, forces, prescribed vertices and field values.
Snapshot make_snapshot(const Session& session, ColorField field);
/// The same at a state that the run has kept, without forces. Status and message are those of the session.
Snapshot make_snapshot(const Session& session, ColorField field, const KeptState& kept);

/// Per vertex: 1 if a [[fix]] or the mouse prescribes its displacement, else 0.
std::vector<std::uint8_t> prescribed_vertices(const Session& session);

}  // namespace tetraction::viewer
