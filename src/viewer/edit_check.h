// Checks an edit as the scene reader does, so that every run in the window can be saved as a scene.
#pragma once

#include "tetraction/simulation/scene.h"

namespace tetraction::viewer {

/// Throws InputError for numbers outside the ranges of docs/scene.md, even if a Session would accept
/// them. Normalises directions.
void check_edit(Edit& edit);

}  // namespace tetraction::viewer
