// What a scene file would refuse of an edit, so that every session can be saved as one.
#pragma once

#include "tetraction/simulation/scene.h"

namespace tetraction::viewer {

/// Throws InputError for numbers out of the ranges of docs/scene.md that a Session itself would take.
/// Directions come out with length 1.
void check_edit(Edit& edit);

}  // namespace tetraction::viewer
