// Settings of a scene as keys with TOML values, which the reader reads back.
#pragma once

#include <string>
#include <vector>

#include "io/toml/toml_text.h"

namespace tetraction {

/// A key of a table with its value as TOML text. Keys of a `select` stand for themselves, dotted:
/// "select.plane.axis".
struct WrittenKey {
  std::string name;
  std::string value;
  std::string unit{};  ///< for a comment
  bool operator==(const WrittenKey&) const = default;
};
using WrittenKeys = std::vector<WrittenKey>;

/// The keys of a section, except those whose value is the default and need not be written, and
/// except selections and lists of tables. Throws InputError for settings that a scene file cannot
/// express.
WrittenKeys keys_of(const SceneSection& section, const void* settings);
template <class Settings>
WrittenKeys keys_of(const Settings& settings) {
  return keys_of(section_of<Settings>(), &settings);
}
inline WrittenKeys keys_of(const ForceSettings& load) {
  return keys_of(section_of(load.kind), &load);
}
/// The selection of settings. Null if they have none.
const Selection* selection_of(const SceneSection& section, const void* settings);

/// The events of a scene as TOML text, from which the reader makes the same edits.
std::string event_text(const Scene& scene);

/// The keys of the table of a selection: "vertices", "plane.axis", …
WrittenKeys selection_keys(const Selection& selection);
/// The keys with their path from `key`, the key that holds the selection: "select.plane.axis", or
/// "select" alone for a named selection. No value is a table.
WrittenKeys selection_keys(const std::string& key, const Selection& selection);

/// { plane = { axis = "x", at = 0.0 } }, or "NAME" for a named selection.
std::string inline_selection(const Selection& selection);
/// { KEY = VALUE, … }, after an optional select.
std::string inline_table(const WrittenKeys& keys, const Selection* select = nullptr);

}  // namespace tetraction
