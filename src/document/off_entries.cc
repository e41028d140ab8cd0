#include "off_entries.h"

#include <filesystem>
#include <sstream>

#include "io/toml/toml_document.h"
#include "io/toml/toml_text.h"
#include "outline.h"
#include "scene_json.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_writer.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

constexpr const char* kTitle = "# Switched off in the window, which can switch it on again:\n";
constexpr const char* kMark = "#:";

bool is_list_of_scene(const std::string& section) {
  return section == kSelections || (find_section(section) != nullptr && is_list(section));
}

}  // namespace

std::string off_entries_text(const std::vector<OffEntry>& entries) {
  std::string text;
  for (const OffEntry& entry : entries) {
    const bool is_selection = entry.section == kSelections;
    std::istringstream lines(is_selection
                                 ? table_text(entry.section, Json{{entry.label, entry.table}})
                                 : table_text(entry.section, Json::array({entry.table})));
    text += text.empty() ? std::string("\n") + kTitle : std::string();
    for (std::string line; std::getline(lines, line);) {
      text += kMark + (" " + line) + "\n";
    }
  }
  return text;
}

std::vector<OffEntry> off_entries_in(const std::string& scene_text) {
  std::string text;
  std::istringstream lines(scene_text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kMark)) text += line.substr(std::string(kMark).size()) + "\n";
  }
  std::vector<OffEntry> entries;
  if (text.empty()) return entries;
  try {
    const Json json = to_json(TomlDocument("", text, std::vector<std::string>()).root());
    for (const auto& [section, tables] : json.items()) {
      if (!is_list_of_scene(section)) continue;
      for (const auto& [key, table] : tables.items()) {
        entries.push_back({section, section == kSelections ? key : text_of_entry(table), table});
      }
    }
  } catch (const Error&) {
    // Someone has written comments of this kind.
  }
  return entries;
}

void write_scene(const Scene& scene, const std::vector<OffEntry>& off, const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  write_text_file(path, scene_text(scene, folder) + off_entries_text(off));
}

}  // namespace tetraction
