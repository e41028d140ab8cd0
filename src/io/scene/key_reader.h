// Reads the keys of a section as its table in simulation/setting_keys.h says.
#pragma once

#include <string>
#include <vector>

#include "io/toml/toml_table.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction {

/// The names that the section may have.
template <class S>
const TableKeys& table_keys() {
  static const TableKeys keys = [] {
    TableKeys names;
    for (const Key<S>& key : section_of<S>().keys) names.valid.emplace_back(key.info.name);
    return names;
  }();
  return keys;
}

/// A table { file = "…" } or { formula = ["…", "…", "…"] }. The path is as the scene has it.
FieldSettings read_field(const TomlTable& parent, std::string_view key);

/// The name in a table { array = "…" }.
std::string read_array_name(const TomlTable& parent, std::string_view key);

/// Reads one key into the settings if the table contains it. Every kind of value has its own
/// function.
template <class S>
struct ValueReader {
  const TomlTable& table;
  const KeyInfo& key;
  S& settings;

  void operator()(int S::*member) const { table.read(key.name, settings.*member, key.range); }
  void operator()(double S::*member) const { table.read(key.name, settings.*member, key.range); }
  void operator()(std::optional<double> S::*member) const {
    table.read(key.name, settings.*member, key.range);
  }
  void operator()(Vector3 S::*member) const { table.read(key.name, settings.*member, key.range); }
  void operator()(std::optional<Vector3> S::*member) const {
    table.read(key.name, settings.*member);
  }
  void operator()(std::array<bool, 3> S::*member) const {
    table.read_letters(key.name, settings.*member);
  }
  void operator()(std::string S::*member) const { table.read(key.name, settings.*member); }
  void operator()(std::array<std::int64_t, 2> S::*member) const {
    table.read_pair(key.name, settings.*member);
  }
  void operator()(std::vector<std::int64_t> S::*member) const {
    table.read(key.name, settings.*member);
  }
  void operator()(std::vector<Vector3> S::*member) const { table.read(key.name, settings.*member); }
  void operator()(bool S::*member) const { table.read(key.name, settings.*member); }
  void operator()(std::vector<std::string> S::*member) const {
    table.read(key.name, settings.*member);
  }
  void operator()(const Choice<S>& choice) const {
    if (!table.has(key.name)) return;
    std::string name;
    table.read(key.name, name, {choice.names.begin(), choice.names.end()},
               {choice.later.begin(), choice.later.end()});
    choice.set(settings, name);
  }
  void operator()(const NumberOrAuto<S>& value) const {
    table.read_or_auto(key.name, settings.*value.number, settings.*value.automatic, key.range);
  }
  void operator()(const NumberOrArray<S>& value) const {
    if (!table.has(key.name)) return;
    if (table.node().get(key.name)->is_table()) {
      value.set(settings, read_array_name(table, key.name));
    } else {
      double number = 0.0;
      table.read(key.name, number, key.range);
      value.set(settings, number);
    }
  }
  void operator()(const VectorOrField<S>& value) const {
    if (!table.has(key.name)) return;
    if (table.node().get(key.name)->is_table()) {
      settings.*value.field = read_field(table, key.name);
    } else {
      table.read(key.name, settings.*value.vector, key.range);
    }
  }
  void operator()(const ByHand&) const {}
};

/// Refuses keys that have no meaning with the settings' `kind`, which has been read before.
template <class S>
void refuse_unused(const TomlTable& table, const S& settings) {
  const std::vector<Key<S>>& keys = section_of<S>().keys;
  NameList own;
  for (const Key<S>& key : keys) {
    if (&key != &keys.front() && key.is_used(settings)) own.emplace_back(key.info.name);
  }
  for (const Key<S>& key : keys) {
    if (key.is_used(settings) || !table.has(key.info.name)) continue;
    table.refuse(key.info.name, "does not belong to " + std::string(keys.front().info.name) +
                                    " = \"" +
                                    std::get<Choice<S>>(keys.front().value).get(settings) +
                                    "\", which takes " + listing(own) + ".");
  }
}

/// Throws InputError if the settings break a rule of their section.
template <class S>
void refuse_conflicts(const TomlTable& table, const S& settings) {
  for (const KeyRule<S>& rule : section_of<S>().rules) {
    const std::string conflict = rule.conflict(settings);
    if (conflict.empty()) continue;
    if (rule.keys.empty()) table.refuse_table(conflict);
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

/// Reads all keys except those with values of their own structure, and checks the rules between
/// them. Absent keys leave the settings unchanged. Throws InputError.
template <class S>
void read_keys(const TomlTable& table, S& settings) {
  const Section<S>& section = section_of<S>();
  for (const Key<S>& key : section.keys) {
    const bool is_used = key.is_used(settings);
    if (is_used && key.info.needed[0] != '\0') table.require(key.info.name, key.info.needed);
    if (is_used || !section.refuses_unused) {
      std::visit(ValueReader<S>{table, key.info, settings}, key.value);
    }
    if (section.refuses_unused && &key == &section.keys.front()) refuse_unused(table, settings);
  }
  refuse_conflicts(table, settings);
}

}  // namespace tetraction
