// What the window says about a scene and its changes, with numbers in the units of the window.
#pragma once

#include <string>
#include <vector>

#include "document/outline.h"
#include "document/scene_changes.h"

namespace tetraction::viewer {

/// The tree of a scene.
std::vector<OutlineGroup> outline_in_units(const Json& scene);
/// text_of_entry() of an entry of a list.
std::string text_in_units(const std::string& section, const Json& table);

/// What a change does, as "Density 1200 kg/m³".
std::string description_of(const SceneChange& change, const Json& scene);

}  // namespace tetraction::viewer
