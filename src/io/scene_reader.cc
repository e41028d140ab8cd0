#include "tetraction/io/scene_reader.h"

#include <fmt/format.h>

#include <filesystem>

#include "scene_echo.h"
#include "scene_sections.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr NumberRange kBelowOne{[](double x) { return x > 0.0 && x < 1.0; },
                                "lie between 0 and 1, both excluded; 1e-8 is usual"};
constexpr NumberRange kPoisson{
    [](double x) { return x > -1.0 && x < 0.5; },
    "lie between -1 and 0.5, both excluded; take 0.45 to 0.49 for rubber-like materials"};
constexpr NumberRange kStrength{[](double x) { return x >= 0.0; },
                                "be 0 or more; turn it with environment.direction"};
constexpr NumberRange kZero{[](double x) { return x == 0.0; },
                            "be 0: damping is not in this version of Tetraction"};

MaterialSettings read_material(const TomlTable& root) {
  root.require("material",
               "under [material], give model, youngs_modulus, poissons_ratio and density.");
  const TomlTable table =
      root.table("material", {{"model", "youngs_modulus", "poissons_ratio", "mu", "lambda", "mu1",
                               "mu2", "ratio", "density"}});
  MaterialSettings material;
  table.read("model", material.model,
             {StVenantKirchhoff::kName, NeoHookean::kName, MooneyRivlin::kName});
  table.read("youngs_modulus", material.youngs_modulus, kPositive);
  table.read("poissons_ratio", material.poissons_ratio, kPoisson);
  table.read("mu", material.mu, kPositive);
  table.read("lambda", material.lambda);
  table.read("mu1", material.mu1, kNotNegative);
  table.read("mu2", material.mu2, kNotNegative);
  table.read("ratio", material.ratio, kNotNegative);
  table.read("density", material.density, kPositive);
  try {
    make_material(material);
  } catch (const InputError& error) {
    // What is wrong lies between the parameters; if one of them came from the command line, the
    // file alone may be right.
    std::string place = table.place();
    for (const std::string_view key :
         {"model", "youngs_modulus", "poissons_ratio", "mu", "lambda", "mu1", "mu2", "ratio"}) {
      if (table.is_override(key)) place = table.place(key);
    }
    const std::string message = error.what();
    const bool named = message.rfind("material", 0) == 0;
    throw InputError(fmt::format("{}: {}{}", place, named ? "" : "material: ", message));
  }
  return material;
}

TimeSettings read_time(const TomlTable& root) {
  TimeSettings time;
  if (!root.has("time")) return time;
  const TomlTable table = root.table("time", {{"integrator", "step", "end"}});
  std::string integrator = to_string(time.integrator);
  table.read("integrator", integrator, {"explicit", "verlet", "midpoint", "backward-euler"},
             {"energy-momentum"});
  time.integrator = integrator_from_string(integrator);
  table.read("end", time.end, kPositive);
  if (!table.has("step") || !table.is_string("step")) {
    table.read("step", time.step, kPositive);
    return time;
  }
  std::string word;
  table.read("step", word);
  if (word != "auto") {
    table.refuse("step",
                 fmt::format("= \"{}\" must be a number of seconds above 0, or \"auto\".", word));
  }
  if (is_implicit(time.integrator)) {
    table.refuse("step", fmt::format("= \"auto\" is for the integrators explicit and verlet: {} "
                                     "has no stability limit to take half of. Give a number of "
                                     "seconds.",
                                     integrator));
  }
  time.automatic = true;
  return time;
}

SolverSettings read_solver(const TomlTable& root) {
  SolverSettings solver;
  if (!root.has("solver")) return solver;
  const TomlTable table =
      root.table("solver", {{"kind", "tolerance", "max_iterations"}, {"linear"}});
  table.read("kind", solver.kind, {"ceres"}, {"newton"});
  table.read("tolerance", solver.tolerance, kBelowOne);
  table.read("max_iterations", solver.max_iterations, 1);
  return solver;
}

void read_damping(const TomlTable& root) {
  if (!root.has("damping")) return;
  const TomlTable table = root.table("damping", {{"drag", "mass_damping", "viscosity"}});
  for (const std::string_view key : {"drag", "mass_damping", "viscosity"}) {
    double none = 0.0;
    table.read(key, none, kZero);
  }
}

EnvironmentSettings read_environment(const TomlTable& root) {
  EnvironmentSettings environment;
  if (!root.has("environment")) return environment;
  const TomlTable table = root.table("environment", {{"kind", "strength", "direction"}});
  table.require("kind", "\"none\" or \"gravity\".");
  std::string kind;
  table.read("kind", kind, {"none", "gravity"}, {"attraction"});
  if (kind == "gravity") environment.kind = EnvironmentKind::kGravity;
  table.read("strength", environment.strength, kStrength);
  table.read("direction", environment.direction);
  if (environment.direction.isZero(0.0)) {
    table.refuse("direction", "must not be zero; [0, -1, 0] is downward.");
  }
  environment.direction.stableNormalize();  // neither tiny nor huge components spoil it
  return environment;
}

OutputSettings read_output(const TomlTable& root) {
  OutputSettings output;
  if (!root.has("output")) return output;
  const TomlTable table = root.table("output", {{"directory", "every", "checkpoint_every"}});
  table.read("directory", output.directory);
  table.read("every", output.every, 1);
  int checkpoint_every = 0;
  table.read("checkpoint_every", checkpoint_every, 0);
  if (checkpoint_every != 0) {
    table.refuse("checkpoint_every",
                 "must be 0: checkpoints are not in this version of Tetraction.");
  }
  return output;
}

}  // namespace

Scene read_scene(const std::string& path, const std::vector<std::string>& overrides) {
  const TomlDocument document(path, overrides);
  const TomlTable root(document, document.root(), "",
                       {{"mesh", "material", "time", "solver", "damping", "environment", "fix",
                         "force", "initial", "output"},
                        {"constraint", "event", "material_region"}});
  Scene scene;
  scene.path = path;
  scene.mesh = read_mesh_settings(root, std::filesystem::path(path).parent_path().string());
  scene.material = read_material(root);
  scene.time = read_time(root);
  scene.solver = read_solver(root);
  read_damping(root);
  scene.environment = read_environment(root);
  for (const TomlTable& table : root.tables("fix", fix_keys())) {
    scene.fix.push_back(read_fix(table));
  }
  for (const TomlTable& table : root.tables("force", force_keys())) {
    scene.force.push_back(read_force(table));
  }
  scene.initial = read_initial(root);
  scene.output = read_output(root);
  scene.echo = scene_echo(scene);
  return scene;
}

}  // namespace tetraction
