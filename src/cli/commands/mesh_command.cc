// tetraction mesh: look at, convert and make meshes.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/console.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "io/mesh/mesh_files.h"
#include "mesh_table.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

void tell(const TetMesh& mesh, const std::string& path) {
  print_result("{}: {}\n", path, size_text(mesh));
}

void write_and_tell(const TetMesh& mesh, const std::string& path) {
  write_mesh(mesh, path);
  tell(mesh, path);
}

// Links and other spellings of a name are the same file.
void refuse_to_overwrite(const std::string& in, const std::string& out) {
  for (const std::string& read : files_of_mesh(in)) {
    for (const std::string& written : files_of_mesh(out)) {
      std::error_code error;
      if (!fs::equivalent(read, written, error)) continue;
      throw InputError(fmt::format(
          "{}, which is being read, would be overwritten{}. Give the converted mesh another name.",
          read, read == written ? "" : fmt::format(" as {}", written)));
    }
  }
}

void warn_of_losses(const MeshWriteReport& written, const std::string& in, const std::string& out) {
  if (!written.lost_groups.empty()) {
    print_warning(
        fmt::format("{}: these groups of {} are lost, wholly or in part: {}. A .msh file holds "
                    "groups of points, lines, triangles and tetrahedra, a .veg file those of "
                    "tetrahedra, the other formats none.",
                    out, in, fmt::join(written.lost_groups, ", ")));
  }
  if (!written.lost_arrays.empty()) {
    print_warning(fmt::format(
        "{}: these arrays of {} are lost: {}. .vtu and .vtk files hold arrays of all names but "
        "their own, .msh files those of 1, 3 and 9 components, the other formats none.",
        out, in, fmt::join(written.lost_arrays, ", ")));
  }
  if (written.changed_regions) {
    print_warning(
        fmt::format("{}: regions of {} change their numbers. A .msh file holds regions above 0, a "
                    ".veg file numbers them from 1.",
                    out, in));
  }
  if (!written.names_with_quotes.empty()) {
    print_warning(
        fmt::format("{}: Gmsh itself reads these names up to the first quotation mark in them: {}.",
                    out, fmt::join(written.names_with_quotes, ", ")));
  }
}

void convert(const std::string& in, const std::string& out, double scale) {
  refuse_to_overwrite(in, out);
  std::vector<std::string> unused;
  RawMesh raw = read_raw_mesh(in, unused);
  const std::vector<RawCell> cells = group_cells(raw);
  const TetMesh mesh = build_mesh(std::move(raw), scale);
  const MeshWriteReport written = write_mesh(mesh, out, cells);
  if (const std::string remarks = mesh_remarks(mesh, unused); !remarks.empty()) print_note(remarks);
  warn_of_losses(written, in, out);
  tell(mesh, out);
}

void add_info(CLI::App& parent) {
  auto* command =
      parent.add_subcommand("info", "Report counts, volume, bounding box, groups and quality");
  auto file = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("file", *file, "Mesh (.vtu .vtk .msh .node .ele .veg)")->required();
  command->add_flag("--json", *json, "Print JSON");
  command->callback([file, json] {
    std::vector<std::string> unused;
    const TetMesh mesh = read_mesh(*file, 1.0, unused);
    const std::vector<QualityMeasure> quality = mesh_quality(mesh);
    if (*json) {
      // Names of files and groups need not be UTF-8, which JSON must be.
      write_json_result(mesh_json(mesh, unused, quality)
                            .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                        "\n");
    } else {
      print_mesh_table(mesh, unused, quality);
    }
  });
}

void add_convert(CLI::App& parent) {
  auto* command = parent.add_subcommand(
      "convert", "Read a mesh file and write it in another format; only .msh keeps all groups");
  auto in = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(1.0);
  command->add_option("in", *in, "Mesh to read")->required();
  command->add_option("out", *out, "Mesh to write (.vtu .vtk .msh .node .ele .veg)")->required();
  command->add_option("--scale", *scale, "Multiplies the coordinates; above 0");
  command->callback([in, out, scale] { convert(*in, *out, *scale); });
}

void add_box(CLI::App& parent, const char* name, const char* what, std::array<double, 3> size,
             std::array<int, 3> cells) {
  struct Arguments {
    std::array<double, 3> size;
    std::array<int, 3> cells;
    std::string out;
  };
  auto* command = parent.add_subcommand(name, what);
  auto a = std::make_shared<Arguments>();
  a->size = size;
  a->cells = cells;
  command->add_option("out", a->out, "Mesh to write")->required();
  command->add_option("--size", a->size, "Edge lengths in m")
      ->delimiter(',')
      ->type_name("X,Y,Z")
      ->default_str(fmt::format("{}", fmt::join(size, ",")));
  command->add_option("--cells", a->cells, "Numbers of cells")
      ->delimiter(',')
      ->type_name("X,Y,Z")
      ->default_str(fmt::format("{}", fmt::join(cells, ",")));
  command->callback([a] {
    write_and_tell(generate_box(Vector3(a->size[0], a->size[1], a->size[2]), a->cells), a->out);
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
  CLI::App* command = app.add_subcommand("mesh", "Inspect, convert and generate meshes");
  command->require_subcommand(1);
  add_info(*command);
  add_convert(*command);
  CLI::App* generate = command->add_subcommand("generate", "Generate a mesh");
  generate->require_subcommand(1);
  add_box(*generate, "beam", "A beam with six tetrahedra in each cell", {4, 1, 1}, {40, 9, 9});
  add_box(*generate, "box", "A box with six tetrahedra in each cell", {1, 1, 1}, {4, 4, 4});
  add_cube(*generate);
  add_tetrahedron(*generate);
  command->callback([&exit_code] { exit_code = 0; });
}

}  // namespace tetraction
