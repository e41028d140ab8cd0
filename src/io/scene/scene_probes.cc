// [[probe]]
#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {

ProbeSettings read_probe(const TomlTable& table) {
  ProbeSettings probe;
  probe.where = table.where();
  read_keys(table, probe);
  if (!probe.point) {
    table.require("select",
                  "say where the probe is: select = { nearest = [x, y, z] }, any other selection, "
                  "or point = [x, y, z].");
    probe.select = read_selection(table);
  } else if (table.has("select")) {
    table.refuse("point",
                 "is one key too many: select and point are both given, and each says where the "
                 "probe is. Leave one of the two out.");
  }
  return probe;
}

}  // namespace tetraction
