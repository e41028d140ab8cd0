// tetraction check: is the scene right, the mesh good, the step stable, the derivatives exact?
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "mesh_table.h"
#include "scene_source.h"
#include "tetraction/dynamics/derivative_check.h"
#include "tetraction/dynamics/stability.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

// Above this the derivatives of a material are wrong, whatever the mesh.
constexpr double kLargestDerivativeError = 1e-7;

// The scene's own material first, then the others with the same small-strain response.
std::vector<MaterialModel> materials_to_check(const MaterialModel& own) {
  const LameParameters lame = initial_lame(own);
  constexpr double kMooneyRatio = 0.25;
  const double mu2 = lame.mu * kMooneyRatio / (1.0 + kMooneyRatio);
  std::vector<MaterialModel> models{own};
  for (const MaterialModel& other :
       {MaterialModel(StVenantKirchhoff(lame.mu, lame.lambda)),
        MaterialModel(NeoHookean(lame.mu, lame.lambda)),
        MaterialModel(MooneyRivlin(lame.mu - mu2, mu2, lame.lambda - 2.0 * mu2))}) {
    if (other.index() != own.index()) models.push_back(other);
  }
  return models;
}

int check(const std::string& path, const std::vector<std::string>& overrides, bool as_json) {
  const Scene scene = read_scene(path, overrides);
  const TetMesh mesh = load_mesh(scene);
  const std::unique_ptr<MechanicalSystem> system = make_system(scene, mesh);
  const State state = make_initial_state(scene, *system);
  const StabilityLimit limit = stability_limit(*system, state.position);
  const LameParameters lame = initial_lame(system->elastic().material());

  nlohmann::ordered_json json;
  json["mesh"] = mesh_json(mesh);
  json["mass"] = system->total_mass();
  json["free_degrees_of_freedom"] = system->constraints().free_count();
  json["material"] = {{"model", material_name(system->elastic().material())},
                      {"mu", lame.mu},
                      {"lambda", lame.lambda},
                      {"density", system->density()}};
  json["wave_speed"] = wave_speed(lame, system->density());
  json["omega_max"] = limit.omega_max;
  json["stable_step"] = limit.critical_step;
  json["stable_step_element"] = mesh.tetrahedron_ids[static_cast<std::size_t>(limit.element)];

  bool exact = true;
  json["derivatives"] = nlohmann::ordered_json::array();
  for (const MaterialModel& material : materials_to_check(system->elastic().material())) {
    const ElasticPotential potential(system->rest(), material);
    const Vector q = strained_state(potential, state.position);
    const DerivativeErrors errors = check_derivatives(potential, q);
    const bool good = errors.force_norm > 0.0 && errors.force < kLargestDerivativeError &&
                      errors.stiffness < kLargestDerivativeError;
    exact = exact && good;
    json["derivatives"].push_back({{"material", material_name(material)},
                                   {"force_error", errors.force},
                                   {"stiffness_error", errors.stiffness},
                                   {"ok", good}});
  }

  if (as_json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}: the scene is valid\n\n", path);
    print_mesh_table(mesh);
    fmt::print(
        "\nmaterial: {} with mu = {:.6g} Pa, lambda = {:.6g} Pa at small strain, density {:.6g} "
        "kg/m3\nmass: {:.6g} kg; wave speed {:.6g} m/s; {} of {} degrees of freedom free\n",
        material_name(system->elastic().material()), lame.mu, lame.lambda, system->density(),
        system->total_mass(), wave_speed(lame, system->density()),
        system->constraints().free_count(), system->dof_count());
    fmt::print(
        "stability limit of the explicit rules: h_crit = 2/omega_max = {:.6g} s (omega_max = "
        "{:.6g} "
        "rad/s, most at element {})\n",
        limit.critical_step, limit.omega_max,
        mesh.tetrahedron_ids[static_cast<std::size_t>(limit.element)]);
    if (scene.time.automatic) {
      fmt::print("time.step = \"auto\" takes {:.6g} s\n", 0.5 * limit.critical_step);
    } else if (!is_implicit(scene.time.integrator)) {
      fmt::print("time.step = {:.6g} s is {:.3g} of it: {}\n", scene.time.step,
                 scene.time.step / limit.critical_step,
                 scene.time.step > limit.critical_step ? "the run will blow up" : "stable");
    } else {
      fmt::print("time.step = {:.6g} s is {:.3g} times it\n", scene.time.step,
                 scene.time.step / limit.critical_step);
    }
    fmt::print(
        "\nanalytic derivatives against central differences, at the initial state strained "
        "by about 10 %:\n{:<16}{:>18}{:>18}\n",
        "material", "forces", "stiffness");
    for (const auto& row : json["derivatives"]) {
      fmt::print("{:<16}{:>18.2e}{:>18.2e}{}\n", row["material"].get<std::string>(),
                 row["force_error"].get<double>(), row["stiffness_error"].get<double>(),
                 row["ok"].get<bool>() ? "" : "   NOT below 1e-7");
    }
  }
  if (!exact) print_warning("the derivatives differ from finite differences by more than 1e-7");
  return exact ? 0 : 1;
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string scene;
    std::vector<std::string> overrides;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "check", "Validate a scene; mesh quality, mass, stable step, exactness of the derivatives");
  command->add_option("scene", arguments->scene, "Scene file (TOML)")->required();
  command->add_option("--set", arguments->overrides, "KEY=VALUE: overrides a scene key")
      ->take_all()
      ->allow_extra_args(false);
  command->add_flag("--json", arguments->json, "Print JSON to stdout");
  command->callback([arguments, &exit_code] {
    exit_code = check(arguments->scene, arguments->overrides, arguments->json);
  });
}

}  // namespace tetraction
