// Turns the settings of a scene into keys with TOML values, which the reader reads back.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A key of a table with its value as TOML text. Keys of a `select` stand for themselves, dotted:
/// "select.plane.axis".
struct SceneKey {
  std::string name;
  std::string value;
  std::string unit{};  ///< for a comment
};
using SceneKeys = std::vector<SceneKey>;

/// The shortest text that reads back as the same number, never as a whole one.
std::string toml_number(double value);
std::string toml_text(const std::string& text);
/// A name as a key of TOML, in quotes where it needs them.
std::string toml_key(const std::string& name);
std::string toml_list(const Vector3& value);
std::string toml_list(const std::vector<std::int64_t>& values);
std::string toml_list(const std::vector<Vector3>& values);
std::string toml_list(const std::array<std::string, 3>& texts);
std::string toml_list(const std::vector<std::string>& values);

/// The keys of a section that has a table (simulation/setting_keys.h), except those whose value is
/// the default and need not be written. Keys with a structure of their own are left out, such as
/// `select` and inner tables.
template <class Settings>
SceneKeys keys_of(const Settings& settings);
/// The same for settings that a scene file cannot always express. They then throw InputError.
SceneKeys keys_of(const MaterialSettings& material);
SceneKeys keys_of(const TimeSettings& time);
/// The keys of its kind of load.
SceneKeys keys_of(const ForceSettings& load);
/// All keys, also `points`, `file`, `sine` or `smooth_step`. A file is named by its absolute path.
SceneKeys keys_of(const AmplitudeSettings& amplitude);
SceneKeys keys_of(const EnvironmentSettings& environment);
/// The keys of the table of a selection: "vertices", "plane.axis", …
SceneKeys selection_keys(const Selection& selection);
/// The keys with their path from `key`, the key that holds the selection: "select.plane.axis", or
/// "select" alone for a named selection. No value is a table.
SceneKeys selection_keys(const std::string& key, const Selection& selection);

/// { plane = { axis = "x", at = 0.0 } }, or "NAME" for a named selection.
std::string inline_selection(const Selection& selection);
/// { KEY = VALUE, … }, after an optional select.
std::string inline_table(const SceneKeys& keys, const Selection* select = nullptr);

}  // namespace tetraction
