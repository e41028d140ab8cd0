// select = { … } or "NAME", [selection.NAME]
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/quoting.h"
#include "key_reader.h"

namespace tetraction {
namespace {

TableKeys selection_keys() {
  return table_keys(section_of<Selection>());
}

// The table of all named selections, or nothing.
std::optional<TomlTable> named_selections(const TomlDocument& document) {
  const toml::table* table = document.root().get_as<toml::table>("selection");
  if (table == nullptr) return std::nullopt;
  TableKeys names;
  for (const auto& [name, value] : *table) names.valid.push_back(name.str());
  return TomlTable(document, *table, "selection", names);
}

// Reads one selection with all selections that it is made of.
class SelectionReader {
 public:
  // The selection under a key, which is a table or the name of another selection.
  Selection read(const TomlTable& parent, std::string_view key) {
    return read(parent, key, *parent.node().get(key), parent.name() + "." + std::string(key));
  }

  // The selection that a name stands for; `all` is the table of names.
  Selection read_definition(const TomlTable& all, const std::string& name) {
    open_.push_back(name);
    Selection selection = read(all, name, all.table(name, selection_keys()));
    open_.pop_back();
    return selection;
  }

  Selection read(const TomlTable& parent, std::string_view key, const TomlTable& table) {
    // Names within names can stand for more selections than any memory holds.
    constexpr std::size_t kMost = 10000;
    if (++count_ > kMost) {
      parent.refuse(key, fmt::format("is made of more than {} selections.", kMost));
    }
    const std::string_view kind = kind_of(parent, key, table);
    if (kind == to_string(SetOperation::kNot)) {
      return SelectSet{SetOperation::kNot, {{read(table, kind)}}};
    }
    for (const SetOperation operation : {SetOperation::kAllOf, SetOperation::kAnyOf}) {
      if (kind == to_string(operation)) return SelectSet{operation, read_parts(table, kind)};
    }
    Selection selection;
    read_value(table, *section_of<Selection>().find(kind), &selection);
    return selection;
  }

 private:
  // `node` is the value of the key of `parent` or an entry of its list; `name` is its dotted path.
  Selection read(const TomlTable& parent, std::string_view key, const toml::node& node,
                 const std::string& name) {
    if (const auto* text = node.as_string()) return read_named(parent, key, text->get());
    if (!node.is_table()) {
      parent.refuse(key, fmt::format("must be a selection, {{ … }}, or the name of a "
                                     "[selection.NAME] in quotes, not {}.",
                                     tetraction::kind_of(node)));
    }
    return read(parent, key,
                TomlTable(parent.document(), *node.as_table(), name, selection_keys()));
  }

  static std::string_view kind_of(const TomlTable& parent, std::string_view key,
                                  const TomlTable& table) {
    const NameList kinds = selection_keys().valid;
    std::string_view kind;
    for (const std::string_view candidate : kinds) {
      if (!table.has(candidate)) continue;
      if (!kind.empty()) {
        parent.refuse(key, fmt::format("has both {} and {}; give one of {}.", kind, candidate,
                                       listing(kinds)));
      }
      kind = candidate;
    }
    if (kind.empty()) {
      parent.refuse(key, fmt::format("is empty; give one of {}.", listing(kinds)));
    }
    return kind;
  }

  std::vector<SelectionPart> read_parts(const TomlTable& table, std::string_view key) {
    const toml::array* list = table.node().get_as<toml::array>(key);
    if (list == nullptr || list->empty()) {
      table.refuse(
          key, "must be a list of one or more selections, like [{ surface = true }, \"NAME\"].");
    }
    std::vector<SelectionPart> parts;
    for (std::size_t i = 0; i < list->size(); ++i) {
      parts.push_back(
          {read(table, key, (*list)[i], fmt::format("{}.{}.{}", table.name(), key, i))});
    }
    return parts;
  }

  Selection read_named(const TomlTable& parent, std::string_view key, const std::string& name) {
    const std::optional<TomlTable> all = named_selections(parent.document());
    NameList names;
    if (all) {
      for (const auto& [known, value] : all->node()) names.push_back(known.str());
    }
    if (names.empty()) {
      parent.refuse(key, fmt::format("= {}, but the scene has no named selections: add "
                                     "[selection.{}], or give a selection, {{ … }}.",
                                     in_quotes(name), excerpt(name)));
    }
    if (!all->has(name)) {
      const std::string_view near = nearest_name(name, names);
      parent.refuse(
          key,
          fmt::format("= {} is not the name of a selection: {}the scene has {}.", in_quotes(name),
                      near.empty() ? "" : fmt::format("did you mean {}? ", near), listing(names)));
    }
    if (std::count(open_.begin(), open_.end(), name) > 0) {
      parent.refuse(
          key,
          fmt::format("= {} makes the selection refer to itself: {} → {}.", in_quotes(name),
                      excerpt(fmt::format("{}", fmt::join(open_, " → ")), 500), excerpt(name)));
    }
    return SelectNamed{name, {{read_definition(*all, name)}}};
  }

  std::vector<std::string> open_;  // the names that are being read
  std::size_t count_ = 0;
};

}  // namespace

Selection read_selection(const TomlTable& parent, std::string_view key) {
  return SelectionReader().read(parent, key);
}

Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table) {
  return SelectionReader().read(parent, key, table);
}

std::vector<NamedSelection> read_named_selections(const TomlTable& root) {
  std::vector<NamedSelection> selections;
  if (!root.has("selection")) return selections;
  if (!root.node().get("selection")->is_table()) root.table("selection", {});  // refuses it
  const TomlTable all = *named_selections(root.document());
  for (const auto& [name, value] : all.node()) {
    selections.push_back(
        {std::string(name.str()), SelectionReader().read_definition(all, std::string(name.str()))});
  }
  return selections;
}

}  // namespace tetraction
