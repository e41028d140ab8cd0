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
                                "be 0 or more; turn it with environment.direction", false, true};
constexpr NumberRange kDamping{[](double x) { return x >= 0.0; },
                               "be 0 or more: negative damping makes energy"};

const NameList kMaterialKeys{"model", "youngs_modulus", "poissons_ratio", "mu", "lambda", "mu1",
                             "mu2",   "ratio",          "density"};

MaterialSettings read_material(const TomlTable& table) {
  MaterialSettings material;
  table.read("model", material.model,
             {StVenantKirchhoff::kName, NeoHookean::kName, MooneyRivlin::kName});
  table.read("youngs_modulus", material.youngs_modulus, kModeratePositive);
  table.read("poissons_ratio", material.poissons_ratio, kPoisson);
  table.read("mu", material.mu, kModeratePositive);
  table.read("lambda", material.lambda, kModerate);
  table.read("mu1", material.mu1, kModerateNotNegative);
  table.read("mu2", material.mu2, kModerateNotNegative);
  table.read("ratio", material.ratio, kNotNegative);
  table.read("density", material.density, kModeratePositive);
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
    std::string message = error.what();
    const std::string own = "material.";
    const bool named = message.rfind(own, 0) == 0;
    if (named) message.erase(0, own.size());
    throw InputError(fmt::format("{}: {}{}{}", place, table.name(), named ? "." : ": ", message));
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
  const TomlTable table = root.table("solver", {{"kind", "linear", "tolerance", "max_iterations"}});
  table.read("kind", solver.kind, {"newton", "ceres"});
  std::string linear = to_string(solver.linear);
  table.read("linear", linear, {"auto", "matrix-free", "cg", "factor"});
  solver.linear = linear_solver_from_string(linear);
  if (const std::string conflict = solver_conflict(solver); !conflict.empty()) {
    table.refuse("linear", conflict);
  }
  table.read("tolerance", solver.tolerance, kBelowOne);
  table.read("max_iterations", solver.max_iterations, 1);
  return solver;
}

MaterialRegionSettings read_material_region(const TomlTable& table) {
  MaterialRegionSettings region;
  region.where = table.where();
  region.select = read_selection(table);
  region.material = read_material(table);
  return region;
}

Damping read_damping(const TomlTable& root) {
  Damping damping;
  if (!root.has("damping")) return damping;
  const TomlTable table = root.table("damping", {{"drag", "mass_damping", "viscosity"}});
  table.read("drag", damping.drag, kDamping);
  table.read("mass_damping", damping.mass_damping, kDamping);
  table.read("viscosity", damping.viscosity, kDamping);
  return damping;
}

EnvironmentSettings read_environment(const TomlTable& root) {
  EnvironmentSettings environment;
  if (!root.has("environment")) return environment;
  const TomlTable table =
      root.table("environment", {{"kind", "strength", "direction", "softening"}});
  table.require("kind", "\"none\", \"gravity\" or \"attraction\".");
  std::string kind;
  table.read("kind", kind, {"none", "gravity", "attraction"});
  if (kind == "gravity") environment.kind = EnvironmentKind::kGravity;
  if (kind == "attraction") environment.kind = EnvironmentKind::kAttraction;
  table.read("strength", environment.strength, kStrength);
  table.read("softening", environment.softening, kModerateNotNegative);
  table.read("direction", environment.direction);
  if (environment.direction.isZero(0.0)) {
    table.refuse("direction", "must not be zero; [0, -1, 0] is downward.");
  }
  environment.direction = unit_direction(environment.direction);
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

const TableKeys& root_keys() {
  static const TableKeys keys{{"mesh", "material", "material_region", "time", "solver", "damping",
                               "environment", "fix", "constraint", "force", "initial", "event",
                               "output"}};
  return keys;
}

// Everything but the events.
Scene read_sections(const TomlDocument& document, const std::string& path) {
  const TomlTable root(document, document.root(), "", root_keys());
  Scene scene;
  scene.path = path;
  scene.mesh = read_mesh_settings(root, std::filesystem::path(path).parent_path().string());
  root.require("material",
               "under [material], give model, youngs_modulus, poissons_ratio and density.");
  scene.material = read_material(root.table("material", {kMaterialKeys}));
  NameList region_keys = kMaterialKeys;
  region_keys.emplace_back("select");
  for (const TomlTable& table : root.tables("material_region", {region_keys})) {
    scene.material_region.push_back(read_material_region(table));
  }
  scene.time = read_time(root);
  scene.solver = read_solver(root);
  scene.damping = read_damping(root);
  scene.environment = read_environment(root);
  for (const TomlTable& table : root.tables("fix", fix_keys())) {
    scene.fix.push_back(read_fix(table));
  }
  for (const TomlTable& table : root.tables("constraint", constraint_keys())) {
    scene.constraint.push_back(read_constraint(table));
  }
  for (const TomlTable& table : root.tables("force", force_keys())) {
    scene.force.push_back(read_force(table));
  }
  scene.initial = read_initial(root);
  scene.output = read_output(root);
  return scene;
}

}  // namespace

Scene read_scene(const std::string& path, const std::vector<std::string>& overrides) {
  const TomlDocument document(path, overrides);
  Scene scene = read_sections(document, path);
  const TomlTable root(document, document.root(), "", root_keys());
  read_events(
      document, root, [&path](const TomlDocument& changed) { return read_sections(changed, path); },
      scene);
  scene.echo = scene_echo(scene);
  return scene;
}

}  // namespace tetraction
