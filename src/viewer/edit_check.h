// Applies the checks of the scene reader to an edit, so that every session can be saved as a scene.
#pragma once

#include "tetraction/simulation/scene.h"

namespace tetraction::viewer {

/// Throws InputError for numbers outside the ranges of docs/scene.md, even those that a Session
/// would accept. Scales directions to length 1.
void check_edit(Edit& edit);

}  // namespace tetraction::viewer
