// select = { … }
#include <fmt/format.h>

#include "scene_sections.h"

namespace tetraction {
namespace {

const NameList kKinds{"vertices", "plane", "box", "sphere", "nearest", "group", "surface", "all"};

Selection read_plane(const TomlTable& table) {
  SelectPlane plane;
  table.require("axis", "\"x\", \"y\" or \"z\", the axis that the plane is normal to.");
  std::string axis;
  table.read("axis", axis, {"x", "y", "z"});
  plane.axis = axis[0] - 'x';
  table.require("at", "the coordinate of the plane along the axis, in m.");
  table.read("at", plane.at);
  table.read("tolerance", plane.tolerance, kNotNegative);
  return plane;
}

Selection read_box(const TomlTable& table) {
  SelectBox box;
  table.require("min", "the lower corner, [x, y, z] in m.");
  table.require("max", "the upper corner, [x, y, z] in m.");
  table.read("min", box.min);
  table.read("max", box.max);
  if ((box.min.array() > box.max.array()).any()) {
    table.refuse("max", "must not be below min in any component; exchange them.");
  }
  return box;
}

Selection read_sphere(const TomlTable& table) {
  SelectSphere sphere;
  table.require("center", "the centre, [x, y, z] in m.");
  table.require("radius", "the radius in m.");
  table.read("center", sphere.center);
  table.read("radius", sphere.radius, kPositive);
  return sphere;
}

}  // namespace

Selection read_selection(const TomlTable& parent) {
  parent.require("select", "say which vertices, for instance select = { all = true }.");
  return read_selection(parent, "select", parent.table("select", {kKinds}));
}

const NameList& selection_kinds() {
  return kKinds;
}

Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table) {
  std::string_view kind;
  for (const std::string_view candidate : kKinds) {
    if (!table.has(candidate)) continue;
    if (!kind.empty()) {
      parent.refuse(key, fmt::format("has both {} and {}; give one of {}.", kind, candidate,
                                     listing(kKinds)));
    }
    kind = candidate;
  }
  if (kind.empty()) {
    parent.refuse(key, fmt::format("is empty; give one of {}.", listing(kKinds)));
  }

  if (kind == "vertices") {
    SelectVertices vertices;
    table.read("vertices", vertices.ids);
    return vertices;
  }
  if (kind == "plane") return read_plane(table.table("plane", {{"axis", "at", "tolerance"}}));
  if (kind == "box") return read_box(table.table("box", {{"min", "max"}}));
  if (kind == "sphere") return read_sphere(table.table("sphere", {{"center", "radius"}}));
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
