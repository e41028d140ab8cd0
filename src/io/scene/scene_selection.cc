// select = { … }
#include <fmt/format.h>

#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {
namespace {

// A kind of selection that is a table of its own.
template <class Kind>
Selection read_kind(const TomlTable& parent, std::string_view key) {
  Kind kind;
  read_keys(parent.table(key, table_keys<Kind>()), kind);
  return kind;
}

}  // namespace

Selection read_selection(const TomlTable& parent) {
  parent.require("select", "say which vertices, for instance select = { all = true }.");
  return read_selection(parent, "select", parent.table("select", table_keys<Selection>()));
}

Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table) {
  const NameList& kinds = table_keys<Selection>().valid;
  std::string_view kind;
  for (const std::string_view candidate : kinds) {
    if (!table.has(candidate)) continue;
    if (!kind.empty()) {
      parent.refuse(
          key, fmt::format("has both {} and {}; give one of {}.", kind, candidate, listing(kinds)));
    }
    kind = candidate;
  }
  if (kind.empty()) {
    parent.refuse(key, fmt::format("is empty; give one of {}.", listing(kinds)));
  }

  if (kind == "vertices") {
    SelectVertices vertices;
    table.read("vertices", vertices.ids);
    return vertices;
  }
  if (kind == "plane") return read_kind<SelectPlane>(table, kind);
  if (kind == "box") return read_kind<SelectBox>(table, kind);
  if (kind == "sphere") return read_kind<SelectSphere>(table, kind);
  if (kind == "nearest") {
    SelectNearest nearest;
    table.read("nearest", nearest.point);
    return nearest;
  }
  if (kind == "group") {
    SelectGroup group;
    table.read("group", group.name);
    return group;
  }
  bool chosen = false;
  table.read(kind, chosen);
  if (!chosen) table.refuse(kind, "can only be true; choose another selection instead.");
  if (kind == "surface") return SelectSurface{};
  return SelectAll{};
}

}  // namespace tetraction
