// Entries of a scene that are switched off, which files keep as comments.
#pragma once

#include <string>
#include <vector>

#include "scene_tables.h"

namespace tetraction {

struct OffEntry {
  std::string section;
  std::string label;  ///< the name of a named selection
  Json table;
};

/// TOML text of the entries behind "#:" in each line, with a title. Empty if there are none.
std::string off_entries_text(const std::vector<OffEntry>& entries);
/// The entries that such lines of a scene have. Lines that cannot be read have none.
std::vector<OffEntry> off_entries_in(const std::string& scene_text);

/// write_scene() with the entries that are off.
void write_scene(const Scene& scene, const std::vector<OffEntry>& off, const std::string& path);

}  // namespace tetraction
