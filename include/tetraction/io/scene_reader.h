// Reads a scene from TOML.
#pragma once

#include <string>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Reads and checks a scene file. `overrides` are KEY=VALUE texts, e.g. "time.step=1e-4". The key
/// is a dotted path, in which list entries are numbers ("force.0.vector"). The value is TOML; a
/// word without quotes is a string. Tables and keys that are absent are created. A message about a
/// value that an override set begins with "--set KEY=VALUE" instead of the place in the file. The
/// path of the mesh file is relative to the scene's folder. Throws FileError if the file is missing
/// or unreadable, InputError (message begins with file:line:column) for TOML syntax errors, unknown
/// keys (with the nearest valid one), wrong types, missing keys and values out of range.
Scene read_scene(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same for a scene that is given as TOML text. Messages name it `path`, and the paths of files in it
/// are relative to the folder of `path`, where no file need be.
Scene read_scene_text(const std::string& text, const std::string& path,
                      const std::vector<std::string>& overrides = {});

}  // namespace tetraction
