// [mesh]
#include <fmt/format.h>

#include <filesystem>

#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {
namespace {

constexpr const char* kNeeded =
    "give file = \"…\" or generate = { kind = \"box\", size = [1, 1, 1], cells = [4, 4, 4] }.";

GeneratorSettings read_generator(const TomlTable& mesh) {
  GeneratorSettings generator;
  const TomlTable table = mesh.table("generate", table_keys<GeneratorSettings>());
  read_keys(table, generator);
  double edge = 1.0;
  switch (generator.kind) {
    case GeneratorKind::kBeam:
    case GeneratorKind::kBox:
      table.require("size", "the lengths along x, y, z in m, for instance [4, 1, 1].");
      table.require("cells", "the numbers of cells along x, y, z, for instance [40, 10, 10].");
      table.read("size", generator.size, kModeratePositive);
      table.read("cells", generator.cells, 1);
      return generator;
    case GeneratorKind::kCube: {
      table.require("cells", "the number of cells along an edge, for instance 8.");
      int cells = 1;
      table.read("cells", cells, 1);
      generator.cells.fill(cells);
      break;
    }
    case GeneratorKind::kTetrahedron:
      break;
  }
  table.read("size", edge, kModeratePositive);
  generator.size.setConstant(edge);
  return generator;
}

}  // namespace

MeshSettings read_mesh_settings(const TomlTable& root, const std::string& folder) {
  root.require("mesh", fmt::format("under [mesh], {}", kNeeded));
  const TomlTable table = root.table("mesh", table_keys<MeshSettings>());
  MeshSettings mesh;
  if (table.has("file") && table.has("generate")) {
    table.refuse(table.is_override("file") ? "file" : "generate",
                 "is one key too many: mesh.file and mesh.generate are both given, and a scene has "
                 "one mesh. Leave one of the two out.");
  }
  if (!table.has("file") && !table.has("generate")) {
    table.refuse_table(fmt::format("has no mesh: {}", kNeeded));
  }
  read_keys(table, mesh);
  if (mesh.quadratic && mesh.volume == VolumeRule::kNodal) {
    table.refuse(
        "volume",
        "= \"nodal\" is for linear tetrahedra, and mesh.element is \"quadratic\": leave one "
        "of the two out. Quadratic tetrahedra do not need it.");
  }
  if (table.has("file")) {
    std::string file;
    table.read("file", file);
    mesh.file = (std::filesystem::path(folder) / file).lexically_normal().string();
  } else {
    mesh.generate = read_generator(table);
    if (mesh.scale != 1.0) {
      table.refuse("scale",
                   "multiplies the coordinates of a mesh file, and this mesh is generated: leave "
                   "it out, and give mesh.generate the size that the mesh shall have.");
    }
    if (mesh.unit != MeshSettings{}.unit) {
      table.refuse("unit",
                   "is that of the coordinates of a mesh file, and this mesh is generated: leave "
                   "it out, and give mesh.generate the size in m.");
    }
  }
  return mesh;
}

}  // namespace tetraction
