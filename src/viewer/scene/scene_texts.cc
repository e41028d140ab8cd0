#include "scene_texts.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

std::string value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  std::string text;
  if (value.is_array()) {
    for (const Json& part : value) text += (text.empty() ? "" : ", ") + value_text(part);
  } else {
    text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  constexpr std::size_t kMost = 40;
  return text.size() <= kMost ? text : text.substr(0, kMost) + "…";
}

// The value under a path of keys and numbers, which exists.
Json& value_at(Json& table, const std::vector<std::string>& path) {
  Json* value = &table;
  for (const std::string& part : path) {
    value = value->is_array() ? &value->at(std::stoul(part)) : &value->at(part);
  }
  return *value;
}

void to_units(Json& table, const std::vector<Field>& fields) {
  for (const Field& field : fields) {
    if (!field.fields.empty()) {
      to_units(table, field.fields);
    } else if (!field.unit.empty() && !field.value.is_null()) {
      value_at(table, field.path) = display_unit(field.unit).from_si(field.value);
    }
  }
}

}  // namespace

std::string text_in_units(const std::string& section, const Json& table) {
  const bool has_other_units = display_unit("m").power != 0;
  if (!has_other_units || has_names(section)) return text_of_entry(table);
  const Json scene{{section, Json::array({table})}};
  Json shown = table;
  to_units(shown, fields_of(scene, {section, 0}));
  return text_of_entry(shown, display_unit("s").text);
}

std::vector<OutlineGroup> outline_in_units(const Json& scene) {
  return outline(scene, text_in_units);
}

std::string description_of(const SceneChange& change, const Json& scene) {
  EntryPlace place = change.place;
  const bool adds = change.kind == SceneChange::Kind::kAdd;
  if (adds) place.index = entry_count(scene, place.section);
  std::string entry = title_of_entry(place);
  if (has_names(place.section)) {  // in place of the number
    const std::string name = name_of_entry(scene, place);
    const std::string title = entry.substr(0, entry.rfind(' '));
    if (adds) entry = title;
    if (!name.empty()) entry = title + " " + name;
  }
  switch (change.kind) {
    case SceneChange::Kind::kAdd:
      return entry + " added";
    case SceneChange::Kind::kRemove:
      return entry + " deleted";
    case SceneChange::Kind::kRename:
      return fmt::format("{} is now {}", entry, value_text(change.value));
    case SceneChange::Kind::kSet:
      break;
  }
  std::string title = change.path.empty() ? "select" : change.path.back();
  DisplayUnit unit;
  const auto find = [&](const auto& self, const std::vector<Field>& fields) -> void {
    for (const Field& field : fields) {
      if (field.path == change.path) {
        title = field.title;
        unit = display_unit(field.unit);
      }
      self(self, field.fields);
    }
  };
  find(find, fields_of(scene, change.place));
  std::string value = "taken out";
  if (!change.value.is_null()) value = value_text(unit.from_si(change.value));
  if (!change.value.is_null() && !unit.text.empty()) value += " " + unit.text;
  const std::string what = fmt::format("{} {}", title, value);
  return is_list(change.place.section) ? fmt::format("{}: {}", entry, what) : what;
}

}  // namespace tetraction::viewer
