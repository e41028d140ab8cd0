#include "tetraction/io/key_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "core/quoting.h"
#include "core/spelling.h"
#include "key_text.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Every kind of value has its own function.
template <class S>
struct TypeText {
  std::string operator()(int S::*) const { return "whole number"; }
  std::string operator()(double S::*) const { return "number"; }
  std::string operator()(std::optional<double> S::*) const { return "number"; }
  std::string operator()(Vector3 S::*) const { return "three numbers"; }
  std::string operator()(std::optional<Vector3> S::*) const { return "three numbers"; }
  std::string operator()(std::array<bool, 3> S::*) const { return "text"; }
  std::string operator()(std::string S::*) const { return "text"; }
  std::string operator()(std::array<std::int64_t, 2> S::*) const { return "two whole numbers"; }
  std::string operator()(std::vector<std::int64_t> S::*) const { return "list of whole numbers"; }
  std::string operator()(std::vector<Vector3> S::*) const { return "list of three numbers each"; }
  std::string operator()(bool S::*) const { return "`true` or `false`"; }
  std::string operator()(std::vector<std::string> S::*) const { return "list of texts"; }
  std::string operator()(const Choice<S>&) const { return "text"; }
  std::string operator()(const NumberOrAuto<S>&) const { return "number"; }
  std::string operator()(const NumberOrArray<S>&) const { return "number or array"; }
  std::string operator()(const VectorOrField<S>&) const { return "three numbers or a table"; }
  std::string operator()(const ByHand& by_hand) const { return by_hand.type; }
};

template <class S>
std::string type_text(const Key<S>& key) {
  std::string text = std::visit(TypeText<S>{}, key.value);
  if (key.info.unit[0] != '\0') text += fmt::format(", {}", key.info.unit);
  if (std::holds_alternative<NumberOrAuto<S>>(key.value)) text += ", or `\"auto\"`";
  return text;
}

// The default as TOML text, or an empty text.
template <class S>
std::string default_text(const Key<S>& key) {
  const S defaults{};
  if (key.info.needed[0] != '\0') return {};
  std::optional<double> number;
  if (const auto* member = std::get_if<double S::*>(&key.value)) number = defaults.*(*member);
  if (const auto* either = std::get_if<NumberOrArray<S>>(&key.value)) {
    number = either->number(defaults);
  }
  if (!number) return std::visit(ValueText<S>{defaults}, key.value);
  std::string value = fmt::format("{}", *number);
  if (const auto zero = value.find("e-0"); zero != std::string::npos) value.erase(zero + 2, 1);
  return value;
}

template <class S>
std::string absent_text(const Key<S>& key) {
  if (key.info.needed[0] == '\0') return key.info.absent;
  return key.used == nullptr ? "must be given" : "–";
}

template <class S>
std::string meaning_text(const Key<S>& key) {
  std::string text = key.info.help;
  if (const auto* choice = std::get_if<Choice<S>>(&key.value)) {
    std::vector<std::string> quoted;
    for (const char* name : choice->names) quoted.push_back(fmt::format("`\"{}\"`", name));
    text += "; " + listing({quoted.begin(), quoted.end()});
  }
  const std::string range = key.info.range.text();
  return range == kFinite.text() ? text : text + "; " + range;
}

template <class S>
std::vector<KeyDescription> descriptions(const Section<S>& section) {
  std::vector<KeyDescription> list;
  list.reserve(section.keys.size());
  for (const Key<S>& key : section.keys) {
    list.push_back(
        {key.info.name, type_text(key), default_text(key), absent_text(key), meaning_text(key)});
  }
  return list;
}

}  // namespace

std::vector<std::string> key_table_names() {
  std::vector<std::string> names;
  for_each_section([&](const auto& section) { names.emplace_back(section.name); });
  return names;
}

std::vector<KeyDescription> key_descriptions(const std::string& name) {
  std::vector<KeyDescription> list;
  for_each_section([&](const auto& section) {
    if (name == section.name) list = descriptions(section);
  });
  if (!list.empty()) return list;
  const std::vector<std::string> names = key_table_names();
  throw InputError(fmt::format("{} is not a section with a table of keys: {}", in_quotes(name),
                               advice(name, {names.begin(), names.end()})));
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
