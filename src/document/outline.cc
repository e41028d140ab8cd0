#include "outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "scene_changes.h"

namespace tetraction {
namespace {

// "Mass damping" for mass_damping, "Young's modulus" for youngs_modulus.
std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  for (const std::string_view person : {"youngs ", "poissons "}) {
    if (name.starts_with(person)) name.insert(person.size() - 2, "'");
  }
  if (!name.empty()) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

std::vector<std::string> section_names() {
  std::vector<std::string> names;
  for (const ScenePart& part : scene_parts()) {
    const std::string_view name = part.section->name;
    if (name == "output") names.emplace_back("event");
    if (name == "probe") names.emplace_back(kSelections);
    names.emplace_back(name);
  }
  return names;
}

// A number as short as possible.
std::string short_text(const Json& value) {
  if (value.is_number()) return fmt::format("{:.4g}", value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  std::string text;
  if (value.is_array()) {
    constexpr std::size_t kMost = 4;
    for (std::size_t i = 0; i < std::min(value.size(), kMost); ++i) {
      text += (i == 0 ? "" : ", ") +
              (value[i].is_object() ? selection_text(value[i]) : short_text(value[i]));
    }
    if (value.size() > kMost) text += fmt::format(", … ({})", value.size());
  } else if (value.is_object()) {
    for (const auto& [key, entry] : value.items()) {
      text += (text.empty() ? "" : ", ") + key + " = " + short_text(entry);
    }
  }
  return text;
}

std::string label_of(const Json& scene, const EntryPlace& place, const Json& table,
                     const EntryText& text_of) {
  if (const std::string name = name_of_entry(scene, place); !name.empty()) return name;
  const std::string text = text_of(place.section, table);
  if (table.contains("at") || text.empty()) {
    return text.empty() ? std::to_string(place.index) : text;
  }
  return fmt::format("{} · {}", place.index, text);
}

// Keys of the environment that have no effect with its kind. The file may have them all the same.
bool has_effect(const OwnedKey& key) {
  if (key.section->type != typeid(EnvironmentSettings)) return true;
  const EnvironmentKind kind = static_cast<const EnvironmentSettings*>(key.settings)->kind;
  const std::string_view name = key.key->info.name;
  if (name == "kind") return true;
  if (name == "direction") return kind == EnvironmentKind::kGravity;
  if (name == "softening") return kind == EnvironmentKind::kAttraction;
  return kind != EnvironmentKind::kNone;
}

// The parameter of its model that a key is, or null.
const MaterialParameter* parameter_of_model(const OwnedKey& key) {
  if (key.section->type != typeid(MaterialSettings)) return nullptr;
  const auto& material = *static_cast<const MaterialSettings*>(key.settings);
  const MaterialChoice* choice = find_material(material.model);
  if (choice == nullptr) return nullptr;
  const std::string_view name = key.key->info.name;
  for (const auto* list : {&choice->parameters, &choice->instead}) {
    for (const MaterialParameter& parameter : *list) {
      if (name == parameter.name) return &parameter;
    }
  }
  return nullptr;
}

// Only the parameters of its model have a meaning.
bool belongs_to_model(const OwnedKey& key) {
  if (key.section->type != typeid(MaterialSettings)) return true;
  const auto& material = *static_cast<const MaterialSettings*>(key.settings);
  const std::vector<MaterialParameter>& all = material_parameters();
  const auto has_name = [&](const MaterialParameter& p) {
    return std::string_view(key.key->info.name) == p.name;
  };
  return find_material(material.model) == nullptr || parameter_of_model(key) != nullptr ||
         std::none_of(all.begin(), all.end(), has_name);
}

FieldKind plain_kind(const OwnedKey& key, const Json& value) {
  const std::string type = key.key->value->type();
  const MaterialParameter* parameter = parameter_of_model(key);
  if (parameter != nullptr && parameter->most_entries == 0 && !value.is_structured()) {
    return FieldKind::kNumber;
  }
  if (type == "number" || (type == "number or array" && !value.is_object())) {
    return FieldKind::kNumber;
  }
  if (type == "whole number") return FieldKind::kWholeNumber;
  if (type == "`true` or `false`" || type == "`true`") return FieldKind::kFlag;
  if (type == "three numbers") return FieldKind::kVector;
  const bool is_list = value.is_array() && value.size() == 3 && value[0].is_number_float();
  if ((type == "three numbers or a table" || type == "three numbers or one") &&
      (is_list || value.is_null())) {
    return FieldKind::kVector;
  }
  if (type == "three numbers or one" && value.is_number()) return FieldKind::kNumber;
  if (type == "text") {
    return std::string_view(key.key->info.name) == "file" ? FieldKind::kFile : FieldKind::kText;
  }
  return FieldKind::kJson;
}

class FieldMaker {
 public:
  explicit FieldMaker(const Json& scene) : scene_(scene) {}

  std::vector<Field> fields(const SceneSection& section, Json& table,
                            const std::vector<std::string>& path) const {
    std::vector<Field> list;
    visit_table(section, table, path, [&](const SceneSection& own, void* settings, Json& inner) {
      for (const OwnedKey& key : owned_keys(own, settings)) {
        if (!key.key->is_used(key.settings) || !has_effect(key) || !belongs_to_model(key)) continue;
        Field made = field(key, inner, path);
        add_inner_fields(section, table, key, made);
        list.push_back(std::move(made));
      }
    });
    return list;
  }

 private:
  Field field(const OwnedKey& key, const Json& table, const std::vector<std::string>& path) const {
    const SceneKey& own = *key.key;
    const KeyInfo& info = own.info;
    Field made;
    made.path = path;
    made.path.emplace_back(info.name);
    made.title = info.title[0] != '\0' ? info.title : in_words(info.name);
    made.unit = own.unit ? own.unit(key.settings) : info.unit;
    if (info.per[0] != '\0') made.unit += std::string(" ") + info.per;
    made.help = info.help;
    made.range = info.range;
    made.usual = info.usual;
    made.word = own.value->word();
    made.value = table.value(info.name, Json());
    made.standard = own.value->json(key.section->defaults.get());
    const auto has = [&](const char* name) { return table.contains(name); };
    made.is_needed =
        !(own.needed ? own.needed(key.settings, has) : std::string(info.needed)).empty();
    for (const char* name : own.value->names()) made.names.emplace_back(name);
    // The name of an entry of another list, such as an amplitude.
    const bool refers = made.names.empty() && find_section(info.name) != nullptr &&
                        own.value->type() == "text" && is_list(info.name) && has_names(info.name);
    if (refers) {
      made.names.emplace_back();
      for (std::size_t i = 0; i < entry_count(scene_, info.name); ++i) {
        made.names.push_back(name_of_entry(scene_, {info.name, i}));
      }
    }
    made.kind = kind_of(key, made);
    made.takes_array = own.value->form() == SettingValue::Form::kPlainOrTable;
    made.takes_field = made.takes_array && made.kind == FieldKind::kVector;
    return made;
  }

  static FieldKind kind_of(const OwnedKey& key, const Field& made) {
    if (!made.names.empty()) return FieldKind::kChoice;
    switch (key.key->value->form()) {
      case SettingValue::Form::kTable:
        return FieldKind::kTable;
      case SettingValue::Form::kTables:
        return FieldKind::kTables;
      case SettingValue::Form::kSelection:
        return FieldKind::kSelection;
      case SettingValue::Form::kOther:
        return FieldKind::kJson;
      case SettingValue::Form::kPlainOrTable:
        if (made.value.is_object()) return FieldKind::kTable;
        break;
      case SettingValue::Form::kPlain:
        break;
    }
    return plain_kind(key, made.shown());
  }

  void add_inner_fields(const SceneSection& section, Json& table, const OwnedKey& key,
                        Field& made) const {
    if (made.kind == FieldKind::kTable && !made.value.is_null()) {
      made.fields = fields(section, table, made.path);
    } else if (made.kind == FieldKind::kSelection && made.value.is_object()) {
      made.fields = fields(section, table, made.path);
      std::erase_if(made.fields, [&](const Field& inner) { return inner.value.is_null(); });
    } else if (made.kind == FieldKind::kTables && made.value.is_array()) {
      for (std::size_t i = 0; i < made.value.size(); ++i) {
        Field entry;
        entry.kind = FieldKind::kTable;
        entry.path = made.path;
        entry.path.push_back(std::to_string(i));
        entry.title = fmt::format("{} {}", in_words(key.key->info.name), i);
        entry.value = made.value[i];
        entry.fields = fields(section, table, entry.path);
        made.fields.push_back(std::move(entry));
      }
    }
  }

  const Json& scene_;
};

}  // namespace

std::string title_of_section(const std::string& section) {
  static constexpr std::array<std::pair<const char*, const char*>, 6> kTitles{
      {{"mesh", "Body and mesh"},
       {"time", "Time steps"},
       {"fix", "Fixed sets"},
       {"initial", "Initial state"},
       {"body_force", "Body forces"},
       {kSelections, "Named selections"}}};
  for (const auto& [name, title] : kTitles) {
    if (section == name) return title;
  }
  return in_words(section) + (is_list(section) ? "s" : "");
}

std::string title_of_entry(const EntryPlace& place) {
  std::string title = title_of_section(place.section);
  if (!is_list(place.section)) return title;
  if (title.ends_with("s")) title.pop_back();
  return title + " " + std::to_string(place.index);
}

std::vector<OutlineGroup> outline(const Json& scene, const EntryText& text) {
  std::vector<OutlineGroup> groups;
  Json tables = scene;
  for (const std::string& section : section_names()) {
    OutlineGroup group{section, title_of_section(section), is_list(section), {}};
    for (std::size_t i = 0; i < entry_count(scene, section); ++i) {
      const EntryPlace place{section, i};
      group.entries.push_back({place, group.is_list
                                          ? label_of(scene, place, table_of(tables, place), text)
                                          : group.title});
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<Field> fields_of(const Json& scene, const EntryPlace& place) {
  if (place.index >= entry_count(scene, place.section)) return {};
  Json copy = scene;
  // A named selection is shown like the selection of an entry.
  if (place.section == kSelections) {
    Field select;
    select.kind = FieldKind::kSelection;
    select.title = "Select";
    select.help = "the vertices";
    select.value = table_of(copy, place);
    select.is_needed = true;
    if (select.value.is_object()) {
      select.fields =
          FieldMaker(scene).fields(section_of_entries(place.section), table_of(copy, place), {});
      std::erase_if(select.fields, [&](const Field& inner) { return inner.value.is_null(); });
    }
    return {select};
  }
  return FieldMaker(scene).fields(section_of_entries(place.section), table_of(copy, place), {});
}

std::string text_of_entry(const Json& table, const std::string& time_unit) {
  if (table.contains("name")) return short_text(table["name"]);
  if (table.contains("select")) return selection_text(table["select"]);
  if (table.contains("at")) return fmt::format("at {} {}", short_text(table["at"]), time_unit);
  return table.contains("kind") ? short_text(table["kind"]) : std::string();
}

std::string selection_text(const Json& select) {
  if (select.is_string()) return select.get<std::string>();
  if (!select.is_object() || select.empty()) return "nothing";
  const std::string kind = select.begin().key();
  const Json& value = select.begin().value();
  if (value.is_boolean()) return kind;
  if (kind == "plane" && value.contains("axis") && value.contains("at")) {
    return fmt::format("plane {} = {}", short_text(value["axis"]), short_text(value["at"]));
  }
  if (kind == "not") return "not " + selection_text(value);
  return kind + " " + short_text(value);
}

}  // namespace tetraction
