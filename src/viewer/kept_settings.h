// The settings made by hand that a run keeps when it starts again.
#pragma once

#include <vector>

#include "edit_history.h"
#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// `made` are the edits of a session that were not undone, in their order. Returns the edits that
/// give the same settings to a session at the start of the same scene. Of several edits of one
/// setting, only the last one counts. Fixed vertices are fixed at their positions at the start,
/// unless a place was given. Moves and kicks of vertices belong to their time and are left out.
std::vector<MadeEdit> kept_settings(const std::vector<MadeEdit>& made, const Session& start);

}  // namespace tetraction::viewer
