// [[fix]] and [[constraint]]
#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {

FixSettings read_fix(const TomlTable& table) {
  FixSettings fix;
  fix.where = table.where();
  fix.select = read_selection(table);
  read_keys(table, fix);
  return fix;
}

ConstraintSettings read_constraint(const TomlTable& table) {
  ConstraintSettings constraint;
  constraint.where = table.where();
  read_keys(table, constraint);
  if (has_selection(constraint.kind)) constraint.select = read_selection(table);
  return constraint;
}

}  // namespace tetraction
