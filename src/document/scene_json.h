// A scene as JSON with the tables and keys of a scene file, for programs that change single values.
#pragma once

#include <string>

#include "simulation/scene/setting_keys.h"

namespace tetraction {

/// An object with a table for each section, a list of tables for each list, and an object for the
/// named selections. Events are as the file had them. A scene whose mesh a program has made has no
/// mesh file. Throws InputError for a scene that a file cannot hold.
Json scene_json(const Scene& scene);

/// TOML text of a table with its keys, or of a list of tables, each under its head.
std::string table_text(const std::string& name, const Json& tables);

/// The scene of such an object, read and checked as a file. `base` gives the path, against which
/// relative paths are read, and the mesh if the object has none. Throws InputError, whose message has no place in a
/// file, and FileError.
Scene scene_of_json(const Json& json, const Scene& base);

}  // namespace tetraction
