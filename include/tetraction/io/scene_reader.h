// Reads a scene from TOML.
#pragma once

#include <string>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Reads and checks a scene file. `overrides` are KEY=VALUE texts, e.g. "time.step=1e-4": the key
/// is a dotted path with list entries by number ("force.0.vector"), the value is TOML (a bare word
/// counts as a string); tables and keys that are absent are made. A message about a value that an
/// override brought in begins with "--set KEY=VALUE" instead.
/// The mesh file's path is taken relative to the scene's folder.
/// Throws FileError if the file is missing or unreadable, InputError (message begins with
/// file:line:column) for TOML syntax errors, unknown keys (with the nearest valid one), wrong
/// types, missing keys and values out of range.
Scene read_scene(const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace tetraction
