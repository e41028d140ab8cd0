#include "toml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "core/quoting.h"
#include "io/text/text_scanner.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"
#include "toml_depth.h"
#include "toml_text.h"

namespace tetraction {
namespace {

constexpr const char* kExample = "write KEY=VALUE, for instance --set time.step=1e-3.";

std::string file_text(const std::string& path) {
  constexpr std::size_t kLargestScene = 64u << 20u;
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) {
    throw FileError(fmt::format("{}: this is a folder; name the scene file in it.", path));
  }
  if (!std::filesystem::exists(status)) {
    throw FileError(
        fmt::format("{}: cannot read the scene: {}. Check the path and the permissions.", path,
                    error ? error.message()
                          : std::make_error_code(std::errc::no_such_file_or_directory).message()));
  }
  if (std::filesystem::file_size(path, error) > kLargestScene && !error) {
    throw FileError(fmt::format("{}: larger than 64 MiB, which no scene is; is it a mesh?", path));
  }
  return read_file(path, kLargestScene);
}

[[noreturn]] void refuse_depth(std::string_view source) {
  throw InputError(fmt::format(
      "{}: not valid TOML for a scene: keys, lists and tables may be nested {} deep at most, and "
      "these are nested deeper. No scene needs as many; look for a dot or a bracket too many.",
      source, kDeepestNesting));
}

// The place of an escape for the character zero, at which names of files and messages would end. toml++
// refuses the character itself.
std::size_t find_zero(std::string_view text) {
  return std::min(text.find("\\u0000"), text.find("\\U00000000"));
}

std::string without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

// The key before a value that begins there, as it is written. Empty if there is none.
std::string_view key_before(std::string_view text, const toml::source_position& value) {
  for (toml::source_index line = 1; line < value.line; ++line) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  std::size_t length = 0;  // of the line before the value, in bytes
  for (toml::source_index column = 1; column < value.column && length < text.size(); ++column) {
    do {
      ++length;
    } while (length < text.size() && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U);
  }
  text = text.substr(0, length);
  const auto trim = [&text] { text = text.substr(0, text.find_last_not_of(" \t") + 1); };
  trim();
  if (text.empty() || text.back() != '=') return {};
  text.remove_suffix(1);
  trim();
  std::size_t begin = text.size();
  while (begin > 0) {
    const char c = text[begin - 1];
    if (c == '"' || c == '\'') {
      const std::size_t open = begin > 1 ? text.rfind(c, begin - 2) : std::string_view::npos;
      if (open == std::string_view::npos) break;
      begin = open;
    } else if (std::strchr(" \t,{[#=", c) == nullptr) {
      --begin;
    } else {
      break;
    }
  }
  return text.substr(begin);
}

// toml++ quotes a key that its table has already with letters too many if the key is in quotes.
std::string text_of(const toml::parse_error& error, std::string_view document) {
  constexpr std::size_t kMost = 400;  // the messages quote keys
  if (error.description().find("cannot redefine existing") != std::string_view::npos) {
    const std::string_view key = key_before(document, error.source().begin);
    if (!key.empty()) {
      return fmt::format("{} is there twice in the same table; leave one of them out.",
                         excerpt(key, kMost));
    }
  }
  return excerpt(error.description(), kMost);
}

// Values are parsed as one-key documents, which gives them the override as their source.
std::optional<toml::table> parse_value(const std::string& text, const std::string& source) {
  try {
    toml::table table = toml::parse("value = " + text, source);
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {
  }
  return std::nullopt;
}

std::string toml_string(const std::string& word) {
  std::string text = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

// The value of an override: TOML, or a bare word as a string.
toml::table override_value(const std::string& text, const std::string& source) {
  if (text.empty()) throw InputError(source + ": the value is missing; " + kExample);
  if (place_of_deep_nesting(text)) refuse_depth(source);
  if (auto table = parse_value(text, source)) return std::move(*table);
  const bool looks_like_toml = std::strchr("[{\"'", text.front()) != nullptr;
  if (!looks_like_toml && text.find('\n') == std::string::npos) {
    if (auto table = parse_value(toml_string(text), source)) return std::move(*table);
  }
  throw InputError(
      fmt::format("{}: the value is not TOML; write a number, true, a word, or something like [0, "
                  "1, 2] or {{ all = true }}, in quotes for the shell.",
                  source));
}

std::optional<std::size_t> as_index(std::string_view segment) {
  std::size_t index = 0;
  const char* end = segment.data() + segment.size();
  const auto [stop, error] = std::from_chars(segment.data(), end, index);
  if (segment.empty() || error != std::errc() || stop != end) return std::nullopt;
  return index;
}

std::vector<std::string> split_key(const std::string& key, const std::string& source) {
  std::vector<std::string> segments(1);
  for (const char c : key) {
    if (c == '.') {
      segments.emplace_back();
    } else {
      segments.back() += c;
    }
  }
  for (std::string& segment : segments) {
    segment = without_blanks(segment);
    if (segment.empty()) throw InputError(source + ": a part of the key is empty; " + kExample);
  }
  if (segments.size() > kDeepestNesting) refuse_depth(source);
  return segments;
}

// Puts `value` (the only value of that table) at one segment below `parent`.
void put(toml::node& parent, const std::string& segment, toml::table value,
         const std::string& where, const std::string& source) {
  value.begin()->second.visit([&](auto& node) {
    if (toml::table* table = parent.as_table()) {
      table->insert_or_assign(toml::key(segment, node.source()), std::move(node));
      return;
    }
    toml::array* array = parent.as_array();
    if (array == nullptr) {
      throw InputError(fmt::format("{}: {} is {}, so it has no {}.", source, excerpt(where),
                                   kind_of(parent), excerpt(segment)));
    }
    const auto index = as_index(segment);
    if (!index || *index > array->size()) {
      throw InputError(fmt::format(
          "{0}: {1} is a list with {2} entries; write {1}.0 for the first, {1}.{2} to add one.",
          source, excerpt(where), array->size()));
    }
    if (*index == array->size()) {
      array->push_back(std::move(node));
    } else {
      array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(*index), std::move(node));
    }
  });
}

// The new node for the missing part segments[i] of a key: a list if a number follows, otherwise a table.
// Three components that have defaults are there before one of them is set.
std::string missing_part(const std::vector<std::string>& segments, std::size_t i) {
  if (!as_index(segments[i + 1])) return "{}";
  const Json components = default_of(std::span(segments).first(i + 1));
  return components.is_array() && components.size() == 3 ? toml_value(components) : "[]";
}

toml::node* child(toml::node& parent, const std::string& segment) {
  if (toml::table* table = parent.as_table()) return table->get(segment);
  if (toml::array* array = parent.as_array()) {
    const auto index = as_index(segment);
    return index ? array->get(*index) : nullptr;
  }
  return nullptr;
}

}  // namespace

TomlDocument::TomlDocument(const std::string& path, const std::vector<std::string>& overrides)
    : TomlDocument(path, file_text(path), overrides) {}

TomlDocument::TomlDocument(const std::string& path, std::string text,
                           const std::vector<std::string>& overrides)
    : TomlDocument(path, std::move(text), std::vector<Change>{}) {
  for (const std::string& setting : overrides) {
    const std::string source = "--set " + excerpt(setting);
    const auto equals = setting.find('=');
    if (equals == std::string::npos) throw InputError(fmt::format("{}: {}", source, kExample));
    apply({without_blanks(setting.substr(0, equals)), without_blanks(setting.substr(equals + 1)),
           source});
  }
}

TomlDocument::TomlDocument(std::string path, std::string text, const std::vector<Change>& changes)
    : path_(std::move(path)), text_(std::move(text)) {
  if (const auto place = place_of_deep_nesting(text_)) {
    refuse_depth(fmt::format("{}:{}:{}", path_, place->line, place->column));
  }
  if (const std::size_t zero = find_zero(text_); zero != std::string::npos) {
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(zero), '\n');
    throw InputError(
        fmt::format("{}:{}: there is a character with the code zero in the text.", path_, line));
  }
  try {
    root_ = toml::parse(text_, path_);
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}: not valid TOML: {}", place_of(error.source()), text_of(error, text_)));
  }
  for (const Change& change : changes) apply(change);
}

void TomlDocument::apply(const Change& change) {
  const std::string& source = change.source;
  const std::vector<std::string> segments = split_key(change.key, source);
  if (change.remove) {
    remove(segments, source);
    changes_.push_back(change);
    return;
  }
  if (find_zero(change.value) != std::string::npos) {
    throw InputError(source + ": there is a character with the code zero in it.");
  }
  toml::table value = override_value(change.value, source);

  toml::node* node = &root_;
  std::string where;
  for (std::size_t i = 0; i + 1 < segments.size(); ++i) {
    toml::node* next = child(*node, segments[i]);
    if (next == nullptr) {
      put(*node, segments[i], *parse_value(missing_part(segments, i), source), where, source);
      next = child(*node, segments[i]);
    }
    where += (where.empty() ? "" : ".") + segments[i];
    node = next;
  }
  put(*node, segments.back(), std::move(value), where, source);
  changes_.push_back(change);
}

void TomlDocument::remove(const std::vector<std::string>& segments, const std::string& source) {
  toml::node* node = &root_;
  for (std::size_t i = 0; i + 1 < segments.size() && node != nullptr; ++i) {
    node = child(*node, segments[i]);
  }
  toml::table* table = node != nullptr ? node->as_table() : nullptr;
  if (table == nullptr || table->erase(segments.back()) == 0) {
    throw InputError(fmt::format("{}: {} is not set at that time, so it cannot be taken out.",
                                 source, excerpt(fmt::format("{}", fmt::join(segments, ".")))));
  }
}

bool TomlDocument::is_override(const toml::node& node) const {
  const auto& path = node.source().path;
  return path && *path != path_;
}

std::string TomlDocument::place_of(const toml::source_region& source) const {
  if (source.path && *source.path != path_) return *source.path;
  // The root table and what was not read from text have no line.
  const auto line = std::max<toml::source_index>(source.begin.line, 1);
  const auto column = std::max<toml::source_index>(source.begin.column, 1);
  return fmt::format("{}:{}:{}", path_, line, column);
}

std::string TomlDocument::place_of(const toml::node& node) const {
  return place_of(node.source());
}

std::string TomlDocument::place_of(const toml::table& table, std::string_view key) const {
  const auto found = table.find(key);
  if (found == table.end()) return place_of(table);
  // A key of the file whose value was overridden keeps its line, but messages name the override.
  if (is_override(found->second) || found->first.source().begin.line == 0) {
    return place_of(found->second);
  }
  return place_of(found->first.source());
}

std::string_view kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

}  // namespace tetraction
