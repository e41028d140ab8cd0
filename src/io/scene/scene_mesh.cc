// [mesh]
#include <fmt/format.h>

#include <filesystem>

#include "key_reader.h"
#include "scene_sections.h"

namespace tetraction {
namespace {

constexpr const char* kNeeded =
    "give file = \"…\" or generate = { kind = \"box\", size = [1, 1, 1], cells = [4, 4, 4] }.";

// Which keys a generator takes depends on its kind, so the kind comes first.
TomlTable generator_table(const TomlTable& mesh, GeneratorKind& kind) {
  TomlTable any = mesh.table("generate", {{"kind", "size", "cells"}});
  any.require("kind", "\"beam\", \"box\", \"cube\" or \"tetrahedron\".");
  std::string name;
  any.read("kind", name, {"beam", "box", "cube", "tetrahedron"});
  kind = name == "beam"   ? GeneratorKind::kBeam
         : name == "box"  ? GeneratorKind::kBox
         : name == "cube" ? GeneratorKind::kCube
                          : GeneratorKind::kTetrahedron;
  if (kind != GeneratorKind::kTetrahedron) return any;
  return mesh.table("generate", {{"kind", "size"}});
}

GeneratorSettings read_generator(const TomlTable& mesh) {
  GeneratorSettings generator;
  const TomlTable table = generator_table(mesh, generator.kind);
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
                 "stands beside the other of mesh.file and mesh.generate; give one of the two.");
  }
  if (!table.has("file") && !table.has("generate")) {
    table.refuse_table(fmt::format("has no mesh: {}", kNeeded));
  }
  read_keys(table, mesh);
  std::string element;
  table.read("element", element, {"linear"}, {"quadratic"});
  if (table.has("file")) {
    std::string file;
    table.read("file", file);
    mesh.file = (std::filesystem::path(folder) / file).lexically_normal().string();
  } else {
    mesh.generate = read_generator(table);
    if (mesh.scale != 1.0) {
      table.refuse("scale", "is for mesh files; give the generated mesh its size instead.");
    }
  }
  return mesh;
}

}  // namespace tetraction
