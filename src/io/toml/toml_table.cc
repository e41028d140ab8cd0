#include "toml_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

bool contains(const NameList& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

TomlTable::TomlTable(const TomlDocument& document, const toml::table& table, std::string name,
                     const TableKeys& keys)
    : document_(&document), table_(&table), name_(std::move(name)) {
  for (const auto& [key, value] : table) {
    if (contains(keys.valid, key.str())) continue;
    if (contains(keys.later, key.str())) {
      refuse(key.str(), "is not in this version of Tetraction; leave it out.");
    }
    throw InputError(fmt::format(
        "{}: unknown key {}{}: {}", place(key.str()), excerpt(path_of(key.str())),
        name_.empty() ? "" : fmt::format(" in [{}]", name_), advice(key.str(), keys.valid)));
  }
}

const toml::node* TomlTable::find(std::string_view key) const {
  return table_->get(key);
}

std::string TomlTable::path_of(std::string_view key) const {
  return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

std::string TomlTable::where() const {
  return fmt::format("{}: {}", document_->place_of(*table_), excerpt(name_));
}

std::string TomlTable::where(std::string_view key) const {
  return fmt::format("{}: {}", place(key), excerpt(path_of(key)));
}

void TomlTable::refuse(std::string_view key, std::string_view message) const {
  throw InputError(fmt::format("{} {}", where(key), message));
}

void TomlTable::refuse_table(std::string_view message) const {
  throw InputError(fmt::format("{} {}", where(), message));
}

void TomlTable::require(std::string_view key, std::string_view remedy) const {
  if (has(key)) return;
  throw InputError(fmt::format("{}: {} is missing: {}", document_->place_of(*table_),
                               excerpt(path_of(key)), remedy));
}

Refusal TomlTable::refusal(std::string_view key) const {
  return {[this, key] { return where(key); }};
}

TomlTable TomlTable::table(std::string_view key, const TableKeys& keys) const {
  const toml::node* node = find(key);
  assert(node != nullptr);
  if (!node->is_table()) {
    refuse(key, fmt::format("must be a table, [{}] or {{ … }}, not {}.", path_of(key),
                            node->is_array_of_tables() ? "a list of tables" : kind_of(*node)));
  }
  return {*document_, *node->as_table(), path_of(key), keys};
}

std::vector<TomlTable> TomlTable::one_or_more_tables(std::string_view key,
                                                     const TableKeys& keys) const {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  if (node->is_array()) return tables(key, keys);
  return {table(key, keys)};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key, const TableKeys& keys) const {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  if (array == nullptr) {
    refuse(key, fmt::format("must be a list of tables, [[{}]], not {}; write the brackets twice.",
                            path_of(key), kind_of(*node)));
  }
  std::vector<TomlTable> tables;
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::node& entry = (*array)[i];
    if (!entry.is_table()) {
      refuse(key, fmt::format("must be a list of tables, [[{}]]; one entry is {}.", path_of(key),
                              kind_of(entry)));
    }
    tables.push_back({*document_, *entry.as_table(), fmt::format("{}.{}", path_of(key), i), keys});
  }
  return tables;
}

}  // namespace tetraction
