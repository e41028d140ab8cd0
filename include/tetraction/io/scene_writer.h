// Writes a scene as TOML that the scene reader reads back.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The scene as TOML text with units in comments. Numbers have the shortest text that reads back
/// bitwise. What has its default value is left out where that reads better. A mesh file is named
/// relative to `folder`, or with its whole path if the two have nothing but the root in common.
///
/// An event whose edits stand in another order than that in which the reader makes them becomes
/// several events of the same time.
/// Throws InputError for what a scene file cannot say: materials and force fields that a program
/// brought, a mesh without file or generator, a run without end.
std::string scene_text(const Scene& scene, const std::string& folder);

/// Writes scene_text() to a file, whole or not at all. Throws OutputError too.
void write_scene(const Scene& scene, const std::string& path);

}  // namespace tetraction
