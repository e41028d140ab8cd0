// [[fix]] and [[constraint]]
#include <fmt/format.h>

#include <algorithm>

#include "scene_sections.h"

namespace tetraction {
namespace {

std::array<bool, 3> read_components(const TomlTable& table) {
  std::string letters = "xyz";
  table.read("components", letters);
  std::array<bool, 3> components{false, false, false};
  for (const char letter : letters) {
    if (letter < 'x' || letter > 'z' || components[static_cast<std::size_t>(letter - 'x')]) {
      table.refuse("components",
                   fmt::format("= \"{}\" must name some of x, y and z, each once, for "
                               "instance \"xz\".",
                               letters));
    }
    components[static_cast<std::size_t>(letter - 'x')] = true;
  }
  return components;
}

void read_distance(const TomlTable& table, ConstraintSettings& constraint) {
  table.require("vertices", "the two vertices, [a, b], as the mesh file numbers them.");
  std::vector<std::int64_t> pair;
  table.read("vertices", pair);
  if (pair.size() != 2 || pair[0] == pair[1]) {
    table.refuse("vertices", "must name two different vertices, like [3, 40].");
  }
  constraint.vertices = {pair[0], pair[1]};
  table.read("length", constraint.length, kPositive);
}

void read_guide(const TomlTable& table, ConstraintSettings& constraint) {
  const bool plane = constraint.kind == ConstraintKind::kPlane;
  const char* key = plane ? "normal" : "direction";
  constraint.select = read_selection(table);
  table.read("point", constraint.point);
  table.require(key, plane ? "the direction that the plane is normal to, [nx, ny, nz]."
                           : "the direction of the line, [dx, dy, dz].");
  table.read(key, constraint.direction);
  if (constraint.direction.isZero(0.0)) table.refuse(key, "must not be zero.");
}

// The keys that a kind of constraint takes, beside `kind`.
NameList keys_of(ConstraintKind kind) {
  switch (kind) {
    case ConstraintKind::kDistance:
      return {"vertices", "length"};
    case ConstraintKind::kPlane:
      return {"select", "point", "normal"};
    case ConstraintKind::kLine:
      return {"select", "point", "direction"};
    case ConstraintKind::kRigid:
      break;
  }
  return {"select", "velocity", "angular_velocity"};
}

}  // namespace

const TableKeys& fix_keys() {
  static const TableKeys keys{
      {"select", "components", "target", "targets", "offset", "velocity", "mode", "penalty"}};
  return keys;
}

FixSettings read_fix(const TomlTable& table) {
  FixSettings fix;
  fix.where = table.where();
  fix.select = read_selection(table);
  fix.components = read_components(table);
  table.read("target", fix.target);
  table.read("offset", fix.offset);
  if (fix.target && fix.offset) {
    table.refuse(table.is_override("target") ? "target" : "offset",
                 "stands beside the other of target and offset; give one of the two.");
  }
  if (table.has("targets")) {
    table.read("targets", fix.targets);
    const auto* select = std::get_if<SelectVertices>(&fix.select);
    if (select == nullptr || select->ids.size() != fix.targets.size()) {
      table.refuse("targets",
                   "goes with select = { vertices = [...] }, one target for each vertex.");
    }
    if (fix.target || fix.offset) {
      table.refuse("targets", "stands beside target or offset; give one of the three.");
    }
  }
  table.read("velocity", fix.velocity);
  std::string mode = "exact";
  table.read("mode", mode, {"exact", "penalty"});
  fix.is_penalty = mode == "penalty";
  if (fix.is_penalty) {
    table.require("penalty", "gamma of the force -2 gamma (q - target), in N/m.");
  }
  table.read("penalty", fix.penalty, kModeratePositive);
  return fix;
}

const TableKeys& constraint_keys() {
  static const TableKeys keys{{"kind", "vertices", "length", "select", "point", "normal",
                               "direction", "velocity", "angular_velocity"}};
  return keys;
}

ConstraintSettings read_constraint(const TomlTable& table) {
  ConstraintSettings constraint;
  constraint.where = table.where();
  table.require("kind", "\"distance\", \"plane\", \"line\" or \"rigid\".");
  std::string kind;
  table.read("kind", kind, {"distance", "plane", "line", "rigid"});
  for (const ConstraintKind candidate : {ConstraintKind::kDistance, ConstraintKind::kPlane,
                                         ConstraintKind::kLine, ConstraintKind::kRigid}) {
    if (kind == to_string(candidate)) constraint.kind = candidate;
  }
  const NameList own = keys_of(constraint.kind);
  for (const std::string_view key : constraint_keys().valid) {
    if (key == "kind" || !table.has(key)) continue;
    if (std::find(own.begin(), own.end(), key) == own.end()) {
      table.refuse(key, fmt::format("does not belong to kind = \"{}\", which takes {}.", kind,
                                    listing(own)));
    }
  }
  switch (constraint.kind) {
    case ConstraintKind::kDistance:
      read_distance(table, constraint);
      break;
    case ConstraintKind::kPlane:
    case ConstraintKind::kLine:
      read_guide(table, constraint);
      break;
    case ConstraintKind::kRigid:
      constraint.select = read_selection(table);
      table.read("velocity", constraint.velocity);
      table.read("angular_velocity", constraint.angular_velocity);
      break;
  }
  return constraint;
}

}  // namespace tetraction
