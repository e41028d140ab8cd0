// [[fix]], [[force]], [initial]
#include <fmt/format.h>

#include "scene_sections.h"

namespace tetraction {
namespace {

constexpr NumberRange kUntil{[](double) { return true; }, "be a time", true};

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

MomentumSettings read_momentum(const TomlTable& table) {
  MomentumSettings momentum;
  momentum.where = table.where();
  momentum.select = read_selection(table);
  table.require("value", "the momentum of each selected vertex, [px, py, pz] in kg m/s.");
  table.read("value", momentum.value);
  return momentum;
}

}  // namespace

const TableKeys& fix_keys() {
  static const TableKeys keys{{"select", "components", "target", "offset", "mode"},
                              {"velocity", "penalty"}};
  return keys;
}

const TableKeys& force_keys() {
  static const TableKeys keys{{"select", "vector", "from", "until"}};
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
  std::string mode;
  table.read("mode", mode, {"exact"}, {"penalty"});
  return fix;
}

ForceSettings read_force(const TomlTable& table) {
  ForceSettings force;
  force.where = table.where();
  force.select = read_selection(table);
  table.require("vector", "the force on each selected vertex, [fx, fy, fz] in N.");
  table.read("vector", force.vector);
  table.read("from", force.from);
  table.read("until", force.until, kUntil);
  if (!(force.until > force.from)) {
    const bool blame_from = table.is_override("from") || !table.has("until");
    table.refuse(blame_from ? "from" : "until",
                 fmt::format("does not fit: the force acts from {} s until {} s; until must be "
                             "later than from.",
                             force.from, force.until));
  }
  return force;
}

InitialSettings read_initial(const TomlTable& root) {
  InitialSettings initial;
  if (!root.has("initial")) return initial;
  const TomlTable table =
      root.table("initial", {{"velocity", "angular_velocity", "stretch", "displacement_array",
                              "velocity_array", "momentum"}});
  table.read("velocity", initial.velocity);
  table.read("angular_velocity", initial.angular_velocity);
  table.read("stretch", initial.stretch, kPositive);
  table.read("displacement_array", initial.displacement_array);
  table.read("velocity_array", initial.velocity_array);
  for (const TomlTable& entry : table.tables("momentum", {{"select", "value"}})) {
    initial.momentum.push_back(read_momentum(entry));
  }
  return initial;
}

}  // namespace tetraction
