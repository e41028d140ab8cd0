#include "written_keys.h"

#include <fmt/format.h>

#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::string unit_text(const SceneKey& key, const void* settings) {
  const char* unit = key.unit ? key.unit(settings) : key.info.unit;
  return key.info.per[0] == '\0' ? unit : fmt::format("{} {}", unit, key.info.per);
}

}  // namespace

WrittenKeys keys_of(const SceneSection& section, const void* settings) {
  if (section.unwritable) {
    const std::string reason = section.unwritable(settings);
    if (!reason.empty()) throw InputError(reason);
  }
  WrittenKeys keys;
  if (section.beside) {
    keys = keys_of(section.beside(), section.settings_beside(const_cast<void*>(settings)));
  }
  for (const SceneKey& key : section.keys) {
    const SettingValue::Form form = key.value->form();
    if (form == SettingValue::Form::kSelection || form == SettingValue::Form::kTables) continue;
    if (section.refuses_unused && !key.is_used(settings)) continue;
    if (!key.is_written(settings)) continue;
    const Json value = key.value->json(settings);
    if (value.is_null()) continue;
    const std::string text = toml_value(value);
    if (key.info.in_file == Written::kUnlessDefault &&
        text == toml_value(key.value->json(section.defaults.get()))) {
      continue;
    }
    keys.push_back(
        {key.info.name, text, value.is_string() ? std::string() : unit_text(key, settings)});
  }
  return keys;
}

const Selection* selection_of(const SceneSection& section, const void* settings) {
  for (const SceneKey& key : section.keys) {
    if (key.value->form() != SettingValue::Form::kSelection || !key.is_used(settings)) continue;
    return key.value->selection(const_cast<void*>(settings));
  }
  return nullptr;
}

WrittenKeys selection_keys(const Selection& selection) {
  // Where a table is needed, a name is the union of that selection alone.
  const auto* named = std::get_if<SelectNamed>(&selection);
  if (named != nullptr) {
    return {{to_string(SetOperation::kAnyOf), fmt::format("[{}]", toml_text(named->name))}};
  }
  const Json json = selection_json(selection);
  const std::string& kind = json.begin().key();
  const Json& value = json.begin().value();
  if (!value.is_object() || std::holds_alternative<SelectSet>(selection)) {
    return {{kind, toml_value(value)}};
  }
  WrittenKeys keys;
  for (const auto& [key, entry] : value.items()) {
    keys.push_back({fmt::format("{}.{}", kind, key), toml_value(entry)});
  }
  return keys;
}

WrittenKeys selection_keys(const std::string& key, const Selection& selection) {
  if (std::holds_alternative<SelectNamed>(selection)) return {{key, inline_selection(selection)}};
  if (const auto* set = std::get_if<SelectSet>(&selection);
      set != nullptr && set->operation == SetOperation::kNot) {
    return selection_keys(key + ".not", set->of.at(0).selection);
  }
  WrittenKeys keys = selection_keys(selection);
  for (WrittenKey& own : keys) own.name = fmt::format("{}.{}", key, own.name);
  return keys;
}

std::string inline_selection(const Selection& selection) {
  return toml_value(selection_json(selection));
}

std::string inline_table(const WrittenKeys& keys, const Selection* select) {
  std::string text = select != nullptr ? "select = " + inline_selection(*select) : std::string();
  for (const WrittenKey& key : keys) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key.name, key.value);
  }
  return "{ " + text + " }";
}

}  // namespace tetraction
