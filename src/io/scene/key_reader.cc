#include "key_reader.h"

#include <functional>
#include <optional>

namespace tetraction {
namespace {

using Refuse = std::function<void(const std::string& message)>;

// Refuses keys that have no meaning with the settings' `kind`, which has been read before.
void refuse_unused(const TomlTable& table, const SceneSection& section, const void* settings) {
  const SceneKey& kind = section.keys.front();
  NameList own;
  for (const SceneKey& key : section.keys) {
    if (&key != &kind && key.is_used(settings)) own.emplace_back(key.info.name);
  }
  for (const SceneKey& key : section.keys) {
    if (key.is_used(settings) || !table.has(key.info.name)) continue;
    table.refuse(key.info.name, "does not belong to " + std::string(kind.info.name) + " = " +
                                    kind.value->json(settings).dump() + ", which takes " +
                                    listing(own) + ".");
  }
}

void refuse_conflicts(const TomlTable& table, const SceneSection& section, const void* settings,
                      const Refuse& refuse_table) {
  for (const SectionRule& rule : section.rules) {
    const std::string conflict = rule.conflict(settings);
    if (conflict.empty()) continue;
    if (rule.keys.empty()) refuse_table(conflict);
    // If one of the keys came from the command line, it is named, because the file alone may be
    // right.
    const char* blamed = nullptr;
    for (const char* key : rule.keys) {
      if (table.is_override(key)) {
        blamed = key;
        break;
      }
      if (table.has(key)) blamed = key;
    }
    table.refuse(blamed != nullptr ? blamed : rule.keys.front(), conflict);
  }
}

void read_settings(const TomlTable& table, const SceneSection& section, void* settings,
                   const Refuse& refuse_table) {
  if (section.where) *section.where(settings) = table.where();
  const auto has = [&](const char* key) { return table.has(key); };
  for (const SceneKey& key : section.keys) {
    const char* name = key.info.name;
    const bool is_used = key.is_used(settings);
    std::string needed;
    if (is_used) needed = key.needed ? key.needed(settings, has) : key.info.needed;
    if (!needed.empty()) table.require(name, needed);
    if (table.has(name) && (is_used || !section.refuses_unused)) {
      read_value(table, key, settings);
      if (section.is_placed_at_key) *section.where(settings) = table.where(name);
    }
    if (section.refuses_unused && &key == &section.keys.front()) {
      refuse_unused(table, section, settings);
    }
  }
  refuse_conflicts(table, section, settings, refuse_table);
  if (section.beside) {
    read_settings(table, section.beside(), section.settings_beside(settings), refuse_table);
  }
}

}  // namespace

TableKeys table_keys(const SceneSection& section) {
  TableKeys names = section.beside ? table_keys(section.beside()) : TableKeys();
  for (const SceneKey& key : section.keys) names.valid.emplace_back(key.info.name);
  return names;
}

void read_settings(const TomlTable& table, const SceneSection& section, void* settings) {
  read_settings(table, section, settings,
                [&](const std::string& message) { table.refuse_table(message); });
}

void read_value(const TomlTable& table, const SceneKey& key, void* settings) {
  const char* name = key.info.name;
  const SettingValue& value = *key.value;
  const auto read_plain = [&] {
    value.read(table.json(name), key.info.range, table.refusal(name), settings);
  };
  const auto read_table = [&] {
    value.read_table(
        [&](const SceneSection& section, void* inner) {
          read_settings(table.table(name, table_keys(section)), section, inner,
                        [&](const std::string& message) { table.refuse(name, message); });
        },
        settings);
  };
  switch (value.form()) {
    case SettingValue::Form::kPlain:
      return read_plain();
    case SettingValue::Form::kTable:
      return read_table();
    case SettingValue::Form::kPlainOrTable:
      return table.node().get(name)->is_table() ? read_table() : read_plain();
    case SettingValue::Form::kTables: {
      const toml::array* list = table.node().get_as<toml::array>(name);
      if (list != nullptr && list->empty()) return;
      std::optional<std::vector<TomlTable>> entries;
      std::size_t next = 0;
      do {
        value.read_table(
            [&](const SceneSection& section, void* entry) {
              if (!entries) entries = table.tables(name, table_keys(section));
              read_settings(entries->at(next++), section, entry);
            },
            settings);
      } while (next < entries->size());
      return;
    }
    case SettingValue::Form::kSelection:
      *value.selection(settings) = read_selection(table, name);
      return;
    case SettingValue::Form::kOther:
      return;
  }
}

}  // namespace tetraction
