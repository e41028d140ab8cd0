// tetraction new: a folder with a commented scene, a mesh and a README to start from.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "cli/console.h"
#include "commands.h"
#include "core/quoting.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/steppers/integrator.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/text_file.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene =
    R"(# A clamped beam of soft rubber that falls under gravity and is pulled at its tip.
# Lengths are in metres, masses in kilograms, times in seconds. `tetraction keys` lists all keys,
# `tetraction keys fix` those of one section.

[mesh]
file = "beam.msh"             # your own: .msh of Gmsh, .vtu, .vtk, .node/.ele of TetGen, .veg
# unit = "mm"                 # of its coordinates, if they are not metres
# element = "quadratic"       # much more accurate in bending; mid-edge vertices are added

[material]
model = "neo-hookean"         # stvk | neo-hookean | mooney-rivlin | yeoh
youngs_modulus = 1.0e5        # Pa
poissons_ratio = 0.3
density = 1000.0              # kg/m3

[environment]
kind = "gravity"              # 9.81 m/s2; none | gravity | attraction
direction = [0, 0, -1]

[damping]
viscosity = 50.0              # Pa s; 0: the energy stays what it was

[time]
integrator = "midpoint"       # INTEGRATORS
step = 2.0e-3                 # s; "auto" for explicit and verlet: half the stability limit
end = 1.0                     # s

[output]
directory = "results"
every = 10                    # a frame for every 10th step

[[fix]]                       # all components of the vertices of a group of the mesh
select = { group = "clamp" }  # or plane, box, sphere, nearest, vertices, surface, all

[[traction]]                  # Pa on the triangles of a group, until 0.2 s
select = { group = "tip" }
vector = [0, 300, 0]
until = 0.2

[[probe]]                     # written to results/probes.csv in every step
name = "tip"
point = [0.4, 0.05, 0.05]
quantity = "displacement"

# [[event]]                   # anything can change between two steps
# at = 0.5
# set = { "material.youngs_modulus" = 5.0e4, "time.step" = 1.0e-3 }
)";

constexpr const char* kReadme =
    R"(# {0}

`scene.toml` describes the simulation, `beam.msh` is its mesh: a beam of 0.4 x 0.1 x 0.1 m with the groups
`clamp` and `tip`. Replace the mesh by your own, and change the scene.

    tetraction check scene.toml          # is the scene all right? quality of the mesh, stable step
    tetraction view scene.toml           # play with it in a window
    tetraction run scene.toml            # results/: frames for ParaView, history.csv, summary.json
    tetraction static scene.toml --out equilibrium     # where does it come to rest?
    tetraction modes scene.toml --out modes            # its natural frequencies
    tetraction study scene.toml --out study            # which integrator and which step?

Any key can be changed without editing the file: `tetraction run scene.toml --set time.step=1e-3`.
In ParaView open `results/frames.pvd` and apply *Warp By Vector* on `displacement`.
)";

TetMesh beam() {
  constexpr double kLength = 0.4;
  TetMesh mesh = generate_box({kLength, 0.1, 0.1}, {16, 4, 4});
  const auto add_end = [&](const char* name, int tag, double x) {
    Group group;
    group.name = name;
    group.dimension = 2;
    group.tag = tag;
    for (const auto& face : boundary_faces(mesh)) {
      const bool is_there = std::all_of(face.begin(), face.end(), [&](Index v) {
        return std::abs(mesh.vertices[static_cast<std::size_t>(v)].x() - x) < 1e-9;
      });
      if (is_there) group.triangles.push_back(face);
    }
    mesh.groups.push_back(std::move(group));
  };
  add_end("clamp", 1, 0.0);
  add_end("tip", 2, kLength);
  return mesh;
}

int make_project(const std::string& folder) {
  std::error_code error;
  const fs::path path(folder);
  if (fs::exists(path, error) && (!fs::is_directory(path, error) || !fs::is_empty(path, error))) {
    throw InputError(fmt::format(
        "{} is there already and is not an empty folder. Give another name.", in_quotes(folder)));
  }
  fs::create_directories(path, error);
  if (error) {
    throw OutputError(
        fmt::format("the folder {} cannot be made ({}).", in_quotes(folder), error.message()));
  }
  write_mesh(beam(), (path / "beam.msh").string());
  std::string scene = kScene;
  constexpr std::string_view kRules = "INTEGRATORS";
  scene.replace(scene.find(kRules), kRules.size(),
                fmt::format("{}", fmt::join(integrator_names(), " | ")));
  write_text_file((path / "scene.toml").string(), scene);
  const std::string name =
      path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
  write_text_file((path / "README.md").string(), fmt::format(fmt::runtime(kReadme), name));
  print_result(
      "{0}: scene.toml, beam.msh, README.md\nTry: cd {0}; tetraction check scene.toml; tetraction "
      "run scene.toml\n",
      folder);
  return 0;
}

}  // namespace

void add_new_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "new", "Make a folder with a commented scene, a mesh and a README to start from");
  const auto folder = std::make_shared<std::string>();
  command->add_option("NAME", *folder, "The folder, which must be new or empty")
      ->required()
      ->check(not_empty("it names no folder"));
  command->callback([folder, &exit_code] { exit_code = make_project(*folder); });
}

}  // namespace tetraction
