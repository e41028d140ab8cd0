// [[force]], [initial]
#include <fmt/format.h>

#include <utility>

#include "scene_sections.h"

namespace tetraction {
namespace {

constexpr NumberRange kUntil{[](double) { return true; }, "be a time", true};

}  // namespace

const TableKeys& force_keys() {
  static const TableKeys keys{{"select", "vector", "from", "until"}};
  return keys;
}

const TableKeys& momentum_keys() {
  static const TableKeys keys{{"select", "value"}};
  return keys;
}

MomentumSettings read_momentum(const TomlTable& table) {
  MomentumSettings momentum;
  momentum.where = table.where();
  momentum.select = read_selection(table);
  table.require("value", "the momentum of each selected vertex, [px, py, pz] in kg m/s.");
  table.read("value", momentum.value);
  return momentum;
}

const TableKeys& shift_keys() {
  static const TableKeys keys{{"vertices", "displacement", "impulse"}};
  return keys;
}

ShiftSettings read_shift(const TomlTable& table) {
  ShiftSettings shift;
  shift.where = table.where();
  table.require("vertices", "the vertices, [a, b, ...], as the mesh file numbers them.");
  table.read("vertices", shift.vertices);
  table.read("displacement", shift.displacement);
  table.read("impulse", shift.impulse);
  if (shift.displacement.empty() && shift.impulse.empty()) {
    table.refuse_table("does nothing: give displacement or impulse, one entry for each vertex.");
  }
  for (const auto& [key, list] :
       {std::pair("displacement", &shift.displacement), std::pair("impulse", &shift.impulse)}) {
    if (list->empty() || list->size() == shift.vertices.size()) continue;
    table.refuse(key, fmt::format("has {} entries for {} vertices; give one for each.",
                                  list->size(), shift.vertices.size()));
  }
  return shift;
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
  for (const TomlTable& entry : table.tables("momentum", momentum_keys())) {
    initial.momentum.push_back(read_momentum(entry));
  }
  return initial;
}

}  // namespace tetraction
