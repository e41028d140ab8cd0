// [[force]], [initial]
#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {

MomentumSettings read_momentum(const TomlTable& table) {
  MomentumSettings momentum;
  momentum.where = table.where();
  momentum.select = read_selection(table);
  read_keys(table, momentum);
  return momentum;
}

ShiftSettings read_shift(const TomlTable& table) {
  ShiftSettings shift;
  shift.where = table.where();
  read_keys(table, shift);
  return shift;
}

ForceSettings read_force(const TomlTable& table) {
  ForceSettings force;
  force.where = table.where();
  force.select = read_selection(table);
  read_keys(table, force);
  return force;
}

InitialSettings read_initial(const TomlTable& root) {
  InitialSettings initial;
  if (!root.has("initial")) return initial;
  const TomlTable table = root.table("initial", table_keys<InitialSettings>());
  read_keys(table, initial);
  for (const TomlTable& entry : table.tables("momentum", table_keys<MomentumSettings>())) {
    initial.momentum.push_back(read_momentum(entry));
  }
  return initial;
}

}  // namespace tetraction
