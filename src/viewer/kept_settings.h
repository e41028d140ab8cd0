// What a run that starts again keeps of what was done by hand.
#pragma once

#include <vector>

#include "edit_history.h"
#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// The edits that give the session at the start of its scene the settings that the edits `made` (in
/// force, in their order) gave another session of the same scene at some later time. Of each setting
/// that is the last one. Vertices that were fixed are fixed where they are at the start, unless a
/// place was given; moves and kicks of vertices belong to their time and are left out.
std::vector<MadeEdit> kept_settings(const std::vector<MadeEdit>& made, const Session& start);

}  // namespace tetraction::viewer
