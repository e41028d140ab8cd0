// The keys of the scene file as tables for people.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The sections whose keys have a table: "mesh", "time", …, "select.plane".
std::vector<std::string> key_table_names();

/// A section of a scene.
struct SectionDescription {
  std::string name;
  bool is_list = false;     ///< whether a scene may have several: [[fix]]
  bool may_change = false;  ///< whether edits may change it
};

/// The sections of a scene, without events and named selections, in the order of summary.json.
std::vector<SectionDescription> section_descriptions();

/// The description of a key of a section.
struct KeyDescription {
  std::string name;
  std::string type;      ///< with the unit: "number, m/s"
  std::string standard;  ///< the default as TOML text; empty if there is no such value
  std::string absent;    ///< otherwise what its absence means: "must be given", "–"
  std::string meaning;   ///< with the range, in Markdown
};

/// The keys of a section in the order of its table. Throws as key_table() does.
std::vector<KeyDescription> key_descriptions(const std::string& section);

/// The keys of a section as a Markdown table: type and unit, default, meaning and range. docs/scene.md
/// holds these tables. Throws InputError for a section that has none.
std::string key_table(const std::string& section);

/// The part of the documentation that explains what an error in a scene is about: "docs/scene.md#fix" for
/// "scene.toml:12:1: fix.0.target …". Empty if the text names no section of a scene at its beginning or after
/// a colon, and no key.
std::string documentation_of(const std::string& error);

}  // namespace tetraction
