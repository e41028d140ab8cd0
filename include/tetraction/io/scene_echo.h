// The scene in effect, as JSON.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The scene as JSON text with the names of the scene file: overrides applied, defaults filled in.
/// Absent and infinite values are left out.
std::string scene_echo(const Scene& scene);

}  // namespace tetraction
