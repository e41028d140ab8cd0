// The keys of the scene file as tables for people.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The sections whose keys have a table: "mesh", "time", …, "select.plane".
std::vector<std::string> key_table_names();

/// The keys of a section as a Markdown table: type and unit, default, meaning and range. docs/scene.md
/// holds these tables. Throws InputError for a section that has none.
std::string key_table(const std::string& section);

}  // namespace tetraction
