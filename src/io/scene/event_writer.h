// [[event]], written.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The events of a scene as TOML text, which the reader makes the same edits of.
std::string event_text(const Scene& scene);

}  // namespace tetraction
