// The settings that the user has changed and that a run keeps when it is restarted.
#pragma once

#include <vector>

#include "edit_history.h"
#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// `made` are the edits of a session that have not been undone, in their order. Returns the edits that
/// give the same settings to a session at the start of the same scene. Of several edits of one
/// setting, only the last one counts. Fixed vertices are fixed at their positions at the start,
/// unless the edit has a target. Edits of positions and momenta are left out, because they apply to
/// the time at which they were made.
std::vector<MadeEdit> kept_settings(const std::vector<MadeEdit>& made, const Session& start);

}  // namespace tetraction::viewer
