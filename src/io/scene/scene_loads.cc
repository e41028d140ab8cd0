// [[force]], [initial]
#include <algorithm>
#include <filesystem>
#include <utility>

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

FieldSettings read_field(const TomlTable& parent, std::string_view key) {
  static const TableKeys keys{{"file", "formula"}};
  const TomlTable table = parent.table(key, keys);
  if (table.has("file") == table.has("formula")) {
    parent.refuse(
        key,
        "must have either file = \"…\" or formula = [\"…\", \"…\", \"…\"], which gives x, y "
        "and z.");
  }
  FieldSettings field;
  field.where = table.where(table.has("file") ? "file" : "formula");
  table.read("file", field.file);
  if (!table.has("formula")) return field;
  std::vector<std::string> formula;
  table.read("formula", formula);
  if (formula.size() != 3 || std::find(formula.begin(), formula.end(), "") != formula.end()) {
    table.refuse("formula", "must have three texts that are not empty: one each for x, y and z.");
  }
  std::move(formula.begin(), formula.end(), field.formula.begin());
  return field;
}

InitialSettings read_initial(const TomlTable& root, const std::string& folder) {
  InitialSettings initial;
  if (!root.has("initial")) return initial;
  const TomlTable table = root.table("initial", table_keys<InitialSettings>());
  read_keys(table, initial);
  for (FieldSettings* field : {&initial.displacement_field, &initial.velocity_field}) {
    if (field->file.empty()) continue;
    field->file = (std::filesystem::path(folder) / field->file).lexically_normal().string();
  }
  for (const TomlTable& entry : table.tables("momentum", table_keys<MomentumSettings>())) {
    initial.momentum.push_back(read_momentum(entry));
  }
  return initial;
}

}  // namespace tetraction
