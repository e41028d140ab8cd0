// Writes a scene as TOML that the scene reader reads back.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Returns the scene as TOML text with units in comments. Each number is the shortest text that
/// reads back bitwise. Some keys with their default value are left out to make the text easier to
/// read (Written in simulation/setting_keys.h). The path of a mesh file is relative to `folder`, or
/// absolute if the two have only the root in common.
///
/// The reader makes the edits of an event in a fixed order. An event whose edits have another order
/// becomes several events of the same time. Throws InputError for a scene that a scene file cannot
/// express: with materials or force fields of a program, with a mesh without file or generator, or
/// with a run without end.
std::string scene_text(const Scene& scene, const std::string& folder);

/// Writes scene_text() to a file, either completely or not at all. Throws OutputError as well.
void write_scene(const Scene& scene, const std::string& path);

}  // namespace tetraction
