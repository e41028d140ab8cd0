// tetraction mesh: look at, convert and make meshes.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "commands.h"
#include "mesh_table.h"
#include "scene_source.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

void write_and_tell(const TetMesh& mesh, const std::string& path) {
  write_mesh(mesh, path);
  fmt::print("{}: {} vertices, {} tetrahedra, volume {:.10g} m3\n", path, mesh.vertex_count(),
             mesh.tetrahedron_count(), mesh.total_volume());
}

void add_info(CLI::App& parent) {
  auto* command = parent.add_subcommand("info", "Counts, volume, bounding box, groups, quality");
  auto file = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("file", *file, "Mesh (.vtu .vtk .msh .node .ele .veg)")->required();
  command->add_flag("--json", *json, "Print JSON");
  command->callback([file, json] {
    const TetMesh mesh = read_mesh(*file);
    if (*json) {
      // Names of files and groups need not be UTF-8, which JSON must be.
      fmt::print("{}\n", mesh_json(mesh).dump(2, ' ', false,
                                              nlohmann::ordered_json::error_handler_t::replace));
    } else {
      print_mesh_table(mesh);
    }
  });
}

void add_convert(CLI::App& parent) {
  auto* command = parent.add_subcommand("convert", "Read one mesh file, write another");
  auto in = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(1.0);
  command->add_option("in", *in, "Mesh to read")->required();
  command->add_option("out", *out, "Mesh to write (.vtu .vtk .msh .node .ele .veg)")->required();
  command->add_option("--scale", *scale, "Multiplies the coordinates")->check(CLI::PositiveNumber);
  command->callback([in, out, scale] {
    const TetMesh mesh = read_mesh(*in, *scale);
    if (const std::string remarks = mesh_remarks(mesh); !remarks.empty()) print_note(remarks);
    write_and_tell(mesh, *out);
  });
}

void add_box(CLI::App& parent, const char* name, const char* what, std::array<double, 3> size,
             std::array<int, 3> cells) {
  struct Arguments {
    std::vector<double> size;
    std::vector<int> cells;
    std::string out;
  };
  auto* command = parent.add_subcommand(name, what);
  auto a = std::make_shared<Arguments>();
  a->size.assign(size.begin(), size.end());
  a->cells.assign(cells.begin(), cells.end());
  command->add_option("out", a->out, "Mesh to write")->required();
  command->add_option("--size", a->size, "Edge lengths in x, y, z, m: 4,1,1")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command->add_option("--cells", a->cells, "Number of cells in x, y, z: 40,9,9")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command->callback([a] {
    write_and_tell(generate_box(Vector3(a->size[0], a->size[1], a->size[2]),
                                {a->cells[0], a->cells[1], a->cells[2]}),
                   a->out);
  });
}

void add_cube(CLI::App& parent) {
  struct Arguments {
    double size = 1.0;
    int cells = 4;
    std::string out;
  };
  auto* command = parent.add_subcommand("cube", "A cube of n x n x n cells");
  auto a = std::make_shared<Arguments>();
  command->add_option("out", a->out, "Mesh to write")->required();
  command->add_option("--size", a->size, "Edge length, m")->capture_default_str();
  command->add_option("--cells", a->cells, "Cells along an edge")->capture_default_str();
  command->callback([a] {
    write_and_tell(generate_box(Vector3::Constant(a->size), {a->cells, a->cells, a->cells}),
                   a->out);
  });
}

void add_tetrahedron(CLI::App& parent) {
  struct Arguments {
    double size = 1.0;
    std::string out;
  };
  auto* command = parent.add_subcommand("tetrahedron", "One corner tetrahedron");
  auto a = std::make_shared<Arguments>();
  command->add_option("out", a->out, "Mesh to write")->required();
  command->add_option("--size", a->size, "Edge length, m")->capture_default_str();
  command->callback([a] { write_and_tell(generate_tetrahedron(a->size), a->out); });
}

}  // namespace

void add_mesh_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("mesh", "Look at, convert and make meshes");
  command->require_subcommand(1);
  add_info(*command);
  add_convert(*command);
  CLI::App* generate = command->add_subcommand("generate", "Make a mesh");
  generate->require_subcommand(1);
  add_box(*generate, "beam", "A beam of six tetrahedra a cell", {4, 1, 1}, {40, 9, 9});
  add_box(*generate, "box", "A box of six tetrahedra a cell", {1, 1, 1}, {4, 4, 4});
  add_cube(*generate);
  add_tetrahedron(*generate);
  command->callback([&exit_code] { exit_code = 0; });
}

}  // namespace tetraction
