#include "toml_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr int kMostInt = std::numeric_limits<int>::max();

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

double TomlTable::number_of(std::string_view key, const toml::node& node, const NumberRange& range,
                            bool in_list) const {
  const char* subject = in_list ? "holds " : "= ";
  if (!node.is_number()) {
    refuse(key, fmt::format("{} {}, not {}.", in_list ? "must be a list of" : "must be",
                            in_list ? "numbers" : "a number", kind_of(node)));
  }
  // toml++ itself converts no whole number that double precision has to round.
  const auto* whole = node.as_integer();
  const double value = whole != nullptr ? static_cast<double>(whole->get()) : *node.value<double>();
  if (const std::string refusal = range.refusal(value); !refusal.empty()) {
    refuse(key, fmt::format("{}{}{}", subject, value, refusal));
  }
  return value;
}

std::int64_t TomlTable::integer_of(std::string_view key, const toml::node& node, std::int64_t least,
                                   std::int64_t most, bool in_list) const {
  if (!node.is_integer()) {
    refuse(key, fmt::format("{} {}, not {}.", in_list ? "must be a list of" : "must be",
                            in_list ? "whole numbers" : "a whole number",
                            node.is_floating_point() ? "a number with a decimal point or exponent"
                                                     : kind_of(node)));
  }
  const std::int64_t value = node.as_integer()->get();
  if (value < least || value > most) {
    refuse(key, fmt::format("{}{}; it must be {}.", in_list ? "holds " : "= ", value,
                            value < least ? fmt::format("{} or more", least)
                                          : fmt::format("{} at most", most)));
  }
  return value;
}

// A list of `size` entries, or of one or more if `size` is 0.
const toml::array& TomlTable::list_of(std::string_view key, const toml::node& node,
                                      std::size_t size, std::string_view example) const {
  const toml::array* array = node.as_array();
  if (array == nullptr) {
    refuse(key, fmt::format("must be a list like {}, not {}.", example, kind_of(node)));
  }
  if (size != 0 ? array->size() != size : array->empty()) {
    refuse(key, fmt::format("has {} entries; it must have {}, like {}.", array->size(),
                            size != 0 ? std::to_string(size) : "at least one", example));
  }
  return *array;
}

void TomlTable::read(std::string_view key, double& target, const NumberRange& range) const {
  if (const toml::node* node = find(key)) target = number_of(key, *node, range, false);
}

void TomlTable::read(std::string_view key, std::optional<double>& target,
                     const NumberRange& range) const {
  if (const toml::node* node = find(key)) target = number_of(key, *node, range, false);
}

void TomlTable::read(std::string_view key, int& target, int least) const {
  if (const toml::node* node = find(key)) {
    target = static_cast<int>(integer_of(key, *node, least, kMostInt, false));
  }
}

void TomlTable::read(std::string_view key, int& target, const NumberRange& range) const {
  if (std::isinf(range.most)) return read(key, target, static_cast<int>(range.least));
  const toml::node* node = find(key);
  if (node == nullptr) return;
  constexpr std::int64_t kAny = std::numeric_limits<std::int64_t>::max();
  const std::int64_t value = integer_of(key, *node, -kAny, kAny, false);
  const std::string refusal = range.refusal(static_cast<double>(value));
  if (!refusal.empty()) refuse(key, fmt::format("= {}{}", value, refusal));
  target = static_cast<int>(value);
}

void TomlTable::read(std::string_view key, Vector3& target, const NumberRange& range) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 3, "[1.0, 0.0, 0.0]");
  for (std::size_t i = 0; i < 3; ++i) {
    target[static_cast<Index>(i)] = number_of(key, list[i], range, true);
  }
}

void TomlTable::read(std::string_view key, std::optional<Vector3>& target) const {
  if (!has(key)) return;
  Vector3 value = Vector3::Zero();
  read(key, value);
  target = value;
}

void TomlTable::read(std::string_view key, std::array<int, 3>& target, int least) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 3, "[40, 10, 10]");
  for (std::size_t i = 0; i < 3; ++i) {
    target[i] = static_cast<int>(integer_of(key, list[i], least, kMostInt, true));
  }
}

void TomlTable::read(std::string_view key, std::array<double, 2>& target,
                     const NumberRange& range) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 2, "[10.0, 100.0]");
  for (std::size_t i = 0; i < 2; ++i) target[i] = number_of(key, list[i], range, true);
}

void TomlTable::read_pair(std::string_view key, std::array<std::int64_t, 2>& target) const {
  if (!has(key)) return;
  std::vector<std::int64_t> pair;
  read(key, pair);
  if (pair.size() != 2 || pair[0] == pair[1]) {
    refuse(key, "must name two different vertices, like [3, 40].");
  }
  target = {pair[0], pair[1]};
}

void TomlTable::read_letters(std::string_view key, std::array<bool, 3>& target) const {
  if (!has(key)) return;
  std::string letters;
  read(key, letters);
  target.fill(false);
  for (const char letter : letters) {
    if (letter < 'x' || letter > 'z' || target[static_cast<std::size_t>(letter - 'x')]) {
      refuse(key, fmt::format("= {} must name some of x, y and z, each once, for instance "
                              "\"xz\".",
                              in_quotes(letters)));
    }
    target[static_cast<std::size_t>(letter - 'x')] = true;
  }
}

void TomlTable::read_or_auto(std::string_view key, double& target, bool& automatic,
                             const NumberRange& range) const {
  if (!has(key)) return;
  if (!is_string(key)) {
    read(key, target, range);
    automatic = false;
    return;
  }
  std::string word;
  read(key, word);
  if (word != "auto") {
    refuse(key, fmt::format("= {} must be a number of seconds {}, or \"auto\".", in_quotes(word),
                            range.text()));
  }
  automatic = true;
}

void TomlTable::read(std::string_view key, std::vector<std::int64_t>& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 0, "[0, 12, 40]");
  target.clear();
  target.reserve(list.size());
  for (const toml::node& entry : list) {
    target.push_back(integer_of(key, entry, 0, std::numeric_limits<std::int64_t>::max(), true));
  }
}

void TomlTable::read(std::string_view key, std::vector<Vector3>& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 0, "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]");
  target.clear();
  target.reserve(list.size());
  for (const toml::node& entry : list) {
    const toml::array& three = list_of(key, entry, 3, "[1.0, 0.0, 0.0]");
    Vector3 value;
    for (std::size_t i = 0; i < 3; ++i) {
      value[static_cast<Index>(i)] = number_of(key, three[i], kFinite, true);
    }
    target.push_back(value);
  }
}

void TomlTable::read(std::string_view key, std::vector<std::pair<double, double>>& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 0, "[[0.0, 0.0], [1.0, 2.5]]");
  target.clear();
  target.reserve(list.size());
  for (const toml::node& entry : list) {
    const toml::array& two = list_of(key, entry, 2, "[1.0, 2.5]");
    target.emplace_back(number_of(key, two[0], kFinite, true),
                        number_of(key, two[1], kFinite, true));
  }
}

void TomlTable::read(std::string_view key, std::vector<std::string>& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array& list = list_of(key, *node, 0, "[\"a\", \"b\"]");
  target.clear();
  for (const toml::node& entry : list) {
    const auto* text = entry.as_string();
    if (text == nullptr) {
      refuse(key, fmt::format("must be a list of texts in quotes, not {}.", kind_of(entry)));
    }
    target.push_back(text->get());
  }
}

void TomlTable::read(std::string_view key, std::string& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto* text = node->as_string();
  if (text == nullptr) {
    refuse(key, fmt::format("must be a text in quotes, not {}.", kind_of(*node)));
  }
  if (text->get().empty()) refuse(key, "is empty; name something or leave the key out.");
  target = text->get();
}

void TomlTable::read(std::string_view key, std::string& target, const NameList& valid,
                     const NameList& later) const {
  if (!has(key)) return;
  std::string word;
  read(key, word);
  if (contains(later, word)) {
    refuse(key,
           fmt::format("= {} is not in this version of Tetraction; valid {} {}.", in_quotes(word),
                       valid.size() == 1 ? "is only" : "are", listing(valid)));
  }
  if (!contains(valid, word)) {
    refuse(key, fmt::format("= {} is unknown: {}", in_quotes(word), advice(word, valid)));
  }
  target = word;
}

void TomlTable::read(std::string_view key, bool& target) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto* value = node->as_boolean();
  if (value == nullptr) refuse(key, fmt::format("must be true or false, not {}.", kind_of(*node)));
  target = value->get();
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
