#include "tetraction/io/key_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "core/quoting.h"
#include "core/spelling.h"
#include "io/toml/toml_text.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::string type_text(const SceneKey& key) {
  std::string text = key.value->type();
  if (key.info.unit[0] != '\0') text += fmt::format(", {}", key.info.unit);
  const char* word = key.value->word();
  return word[0] == '\0' ? text : fmt::format("{}, or `\"{}\"`", text, word);
}

// The default as TOML text, or an empty text.
std::string default_text(const SceneSection& section, const SceneKey& key) {
  if (key.info.needed[0] != '\0') return {};
  const Json value = key.value->json(section.defaults.get());
  if (value.is_null()) return key.info.range.infinity ? "inf" : "";
  if (!value.is_number_float() || key.value->word()[0] != '\0') return toml_value(value);
  std::string text = fmt::format("{}", value.get<double>());
  if (const auto zero = text.find("e-0"); zero != std::string::npos) text.erase(zero + 2, 1);
  return text;
}

std::string absent_text(const SceneKey& key) {
  if (key.info.needed[0] == '\0') return key.info.absent;
  return key.used == nullptr ? "must be given" : "–";
}

std::string meaning_text(const SceneKey& key) {
  std::string text = key.info.help;
  std::vector<std::string> quoted;
  for (const char* name : key.value->names()) quoted.push_back(fmt::format("`\"{}\"`", name));
  if (!quoted.empty()) text += "; " + listing({quoted.begin(), quoted.end()});
  const std::string range = key.info.range.text();
  return range == kFinite.text() ? text : text + "; " + range;
}

}  // namespace

std::vector<std::string> key_table_names() {
  std::vector<std::string> names;
  for (const SceneSection& section : documented_sections()) names.emplace_back(section.name);
  return names;
}

std::vector<SectionDescription> section_descriptions() {
  std::vector<SectionDescription> list;
  for (const ScenePart& part : scene_parts()) {
    list.push_back({part.section->name, part.is_list, part.may_change});
  }
  return list;
}

std::vector<KeyDescription> key_descriptions(const std::string& name) {
  const std::vector<std::string> names = key_table_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw InputError(fmt::format("{} is not a section with a table of keys: {}", in_quotes(name),
                                 advice(name, {names.begin(), names.end()})));
  }
  const SceneSection& section = *find_section(name);
  std::vector<KeyDescription> list;
  list.reserve(section.keys.size());
  for (const SceneKey& key : section.keys) {
    const bool in_words = std::string_view(key.info.absent) != KeyInfo{}.absent;
    list.push_back({key.info.name, type_text(key), in_words ? "" : default_text(section, key),
                    absent_text(key), meaning_text(key)});
  }
  return list;
}

std::string key_table(const std::string& name) {
  std::string text =
      "| key | type, unit | default | meaning and range |\n| --- | --- | --- | --- |\n";
  for (const KeyDescription& key : key_descriptions(name)) {
    const std::string standard =
        key.standard.empty() ? key.absent : fmt::format("`{}`", key.standard);
    text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, key.type, standard, key.meaning);
  }
  return text;
}

std::string documentation_of(const std::string& error) {
  static const std::vector<std::string> sections = [] {
    std::vector<std::string> names{"selection"};
    for (const std::string& name : key_table_names()) {
      // Tables inside a section are explained with it: "mesh.generate".
      if (name.find('.') == std::string::npos && name != "select" && name != "shift") {
        names.push_back(name);
      }
    }
    return names;
  }();
  const auto is_part = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
  };
  // The path of keys that begins at a place: "fix.0.target" of "fix.0.target = 3".
  const auto path_at = [&](std::size_t begin) {
    std::size_t end = begin;
    while (end < error.size() && is_part(error[end])) ++end;
    return std::string_view(error).substr(begin, end - begin);
  };
  const auto page_of = [](std::string_view path) -> std::string {
    const std::string_view section = path.substr(0, path.find('.'));
    if (std::find(sections.begin(), sections.end(), section) == sections.end()) return {};
    const bool is_selection = section == "selection" || path.find(".select") != path.npos;
    return fmt::format("docs/scene.md#{}", is_selection ? "selections" : section);
  };
  // After the place in the file or on the command line.
  for (std::size_t begin = 0; begin != std::string::npos;) {
    if (std::string page = page_of(path_at(begin)); !page.empty()) return page;
    const std::size_t colon = error.find(": ", begin);
    begin = colon == std::string::npos ? colon : colon + 2;
  }
  constexpr std::string_view kUnknown = ": unknown key ";
  const std::size_t unknown = error.find(kUnknown);
  if (unknown == std::string::npos) return {};
  const std::string page = page_of(path_at(unknown + kUnknown.size()));
  return page.empty() ? "docs/scene.md" : page;
}

}  // namespace tetraction
