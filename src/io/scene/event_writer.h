// Writes [[event]].
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The events of a scene as TOML text, from which the reader makes the same edits.
std::string event_text(const Scene& scene);

}  // namespace tetraction
