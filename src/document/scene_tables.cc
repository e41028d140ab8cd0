#include "scene_tables.h"

#include <algorithm>
#include <cassert>
#include <string_view>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

const ScenePart* part_of(std::string_view section) {
  for (const ScenePart& part : scene_parts()) {
    if (section == part.section->name) return &part;
  }
  return nullptr;
}

const SceneSection& selection_table() {
  return *find_section("select");
}

const Refusal kRefusal{[] { return std::string(); }};

// Reads an inner table into settings of its own, without its values.
void read_inner(const OwnedKey& key, const TableReader& reader) {
  key.key->value->read_table(reader, key.settings);
}

void read_value(const OwnedKey& key, const Json& value);

void read_table(const SceneSection& section, void* settings, const Json& table) {
  if (!table.is_object()) return;
  for (const OwnedKey& key : owned_keys(section, settings)) {
    const auto found = table.find(key.key->info.name);
    if (found == table.end() || found->is_null()) continue;
    try {
      read_value(key, *found);
    } catch (const InputError&) {
      // The reader of the whole scene says what is wrong.
    }
  }
}

void read_value(const OwnedKey& key, const Json& value) {
  const auto inner = [&](const Json& table) {
    read_inner(key, [&](const SceneSection& section, void* settings) {
      read_table(section, settings, table);
    });
  };
  const auto plain = [&] {
    key.key->value->read(value, key.key->info.range, kRefusal, key.settings);
  };
  switch (key.key->value->form()) {
    case SettingValue::Form::kPlain:
      return plain();
    case SettingValue::Form::kTable:
      return inner(value);
    case SettingValue::Form::kPlainOrTable:
      return value.is_object() ? inner(value) : plain();
    case SettingValue::Form::kTables:
      for (const Json& table : value) inner(table);
      return;
    case SettingValue::Form::kSelection:
      return read_table(selection_table(), key.key->value->selection(key.settings), value);
    case SettingValue::Form::kOther:
      return;
  }
}

// Calls a function with new settings of a section that is not an inner one, or of a selection.
void with_new_settings(const SceneSection& section, const std::function<void(void*)>& use) {
  if (const ScenePart* part = part_of(section.name)) {
    Scene scene;
    return use(part->add(scene));
  }
  if (section.type == typeid(EventSettings)) {
    EventSettings event;
    return use(&event);
  }
  Selection selection;
  use(&selection);
}

void visit_inner(const SceneSection& section, void* settings, Json& table,
                 std::span<const std::string> path, const TableVisit& visit) {
  read_table(section, settings, table);
  if (path.empty()) return visit(section, settings, table);
  for (const OwnedKey& key : owned_keys(section, settings)) {
    if (path.front() != key.key->info.name) continue;
    Json& value = table[path.front()];
    std::span<const std::string> rest = path.subspan(1);
    const SettingValue::Form form = key.key->value->form();
    if (form == SettingValue::Form::kSelection) {
      if (!value.is_object()) return;
      return visit_inner(selection_table(), key.key->value->selection(key.settings), value, rest,
                         visit);
    }
    Json* inner = &value;
    if (form == SettingValue::Form::kTables) {
      if (rest.empty()) return;
      if (!value.is_array()) value = Json::array();
      const auto number = static_cast<std::size_t>(std::stoul(rest.front()));
      if (number > value.size()) return;
      if (number == value.size()) value.push_back(Json::object());
      inner = &value[number];
      rest = rest.subspan(1);
    }
    if (!inner->is_object()) return;
    bool is_first = true;
    return read_inner(key, [&](const SceneSection& own, void* fresh) {
      if (std::exchange(is_first, false)) visit_inner(own, fresh, *inner, rest, visit);
    });
  }
}

bool breaks_rule(const OwnedKey& key) {
  return std::any_of(key.section->rules.begin(), key.section->rules.end(),
                     [&](const SectionRule& rule) {
                       const auto names = [&](const char* name) {
                         return std::string_view(name) == key.key->info.name;
                       };
                       return std::any_of(rule.keys.begin(), rule.keys.end(), names) &&
                              !rule.conflict(key.settings).empty();
                     });
}

}  // namespace

const SceneSection& section_of_entries(const std::string& name) {
  return name == kSelections ? selection_table() : *find_section(name);
}

bool is_list(const std::string& section) {
  const ScenePart* part = part_of(section);
  return part == nullptr || part->is_list;
}

std::size_t entry_count(const Json& scene, const std::string& section) {
  if (!is_list(section)) return 1;
  const auto found = scene.find(section);
  return found == scene.end() ? 0 : found->size();
}

Json& table_of(Json& scene, const EntryPlace& place) {
  Json& entries = scene[place.section];
  if (place.section == kSelections)
    return std::next(entries.begin(), static_cast<std::ptrdiff_t>(place.index)).value();
  if (is_list(place.section)) return entries.at(place.index);
  if (entries.is_null()) entries = Json::object();
  return entries;
}

std::vector<OwnedKey> owned_keys(const SceneSection& section, void* settings) {
  std::vector<OwnedKey> keys;
  for (const SceneKey& key : section.keys) keys.push_back({&section, &key, settings});
  if (section.beside) {
    for (OwnedKey key : owned_keys(section.beside(), section.settings_beside(settings))) {
      keys.push_back(key);
    }
  }
  return keys;
}

void visit_table(const SceneSection& section, Json& table, std::span<const std::string> path,
                 const TableVisit& visit) {
  with_new_settings(section,
                    [&](void* settings) { visit_inner(section, settings, table, path, visit); });
}

bool is_possible(const OwnedKey& key, const Json& value) {
  try {
    read_value(key, value);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

Json usual_value(const OwnedKey& key, const Json& select) {
  const SettingValue& value = *key.key->value;
  if (!value.names().empty()) return value.names().front();
  const auto inner_table = [&] {
    Json table = Json::object();
    read_inner(key, [&](const SceneSection& section, void* settings) {
      for (const OwnedKey& own : owned_keys(section, settings)) {
        const auto has = [&](const char* name) { return table.contains(name); };
        const std::string needed =
            own.key->needed ? own.key->needed(settings, has) : std::string(own.key->info.needed);
        if (needed.empty() || !own.key->is_used(settings)) continue;
        table[own.key->info.name] = usual_value(own, select);
        is_possible(own, table[own.key->info.name]);  // keys may depend on those before
      }
    });
    return table;
  };
  switch (value.form()) {
    case SettingValue::Form::kSelection:
      return select;
    case SettingValue::Form::kTable:
      return inner_table();
    case SettingValue::Form::kTables:
      return Json::array({inner_table()});
    case SettingValue::Form::kOther:
      return {};
    case SettingValue::Form::kPlain:
    case SettingValue::Form::kPlainOrTable:
      break;
  }
  const Json standard = value.json(key.section->defaults.get());
  std::vector<Json> candidates;
  // The vertices that are selected, or two of them, for a distance between them.
  const auto chosen = select.find("vertices");
  if (key.key->info.name == std::string_view("vertices") && chosen != select.end()) {
    candidates.push_back(*chosen);
    candidates.push_back({chosen->front(), chosen->back()});
  }
  if (!standard.is_null()) candidates.push_back(standard);
  for (const char* text : {"true", "1.0", "1", "[0.0, 1.0, 0.0]", "[1.0, 1.0, 1.0]", "[0, 1]",
                           "[1.0, 2.0]", "[[0.0, 0.0], [1.0, 1.0]]", "[0]", "[[0.0, 0.0, 0.0]]",
                           "[4, 4, 4]", "4", "\"x\"", "[\"0\", \"0\", \"0\"]"}) {
    candidates.push_back(Json::parse(text));
  }
  for (const Json& candidate : candidates) {
    if (is_possible(key, candidate) && !breaks_rule(key)) return candidate;
  }
  return {};
}

Json selection_of_kind(const std::string& kind, const Json& select) {
  Selection selection;
  for (const OwnedKey& key : owned_keys(selection_table(), &selection)) {
    if (kind != key.key->info.name) continue;
    Json value = usual_value(key, select);
    if (value.is_null()) value = kind == "not" ? select : Json::array({select});
    return {{kind, value}};
  }
  return select;
}

void complete_table(const SceneSection& section, Json& table, std::span<const std::string> path,
                    const std::string& kept, const Json& select) {
  visit_table(section, table, path, [&](const SceneSection& own, void* settings, Json& inner) {
    for (const OwnedKey& key : owned_keys(own, settings)) {
      const char* name = key.key->info.name;
      if (!key.key->is_used(key.settings)) {
        if (key.section->refuses_unused && name != kept) inner.erase(name);
        continue;
      }
      // A list where another kind takes a number, for instance.
      if (inner.contains(name) && name != kept && !is_possible(key, inner[name])) inner.erase(name);
      const auto has = [&](const char* other) { return inner.contains(other); };
      const std::string needed =
          key.key->needed ? key.key->needed(key.settings, has) : std::string(key.key->info.needed);
      if (needed.empty() || inner.contains(name)) continue;
      Json value = usual_value(key, select);
      if (value.is_null()) continue;
      is_possible(key, value);  // other keys may depend on it
      inner[name] = std::move(value);
    }
  });
}

}  // namespace tetraction
