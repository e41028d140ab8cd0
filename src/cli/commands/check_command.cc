// tetraction check: is the scene right, the mesh good, the step stable, the derivatives exact?
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/console.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "contact_check.h"
#include "dynamics/steppers/rotated_guess.h"
#include "mesh/bounding_box.h"
#include "mesh_table.h"
#include "scene_facts.h"
#include "simulation/scene/initial_state.h"
#include "simulation/scene/parallel_features.h"
#include "spectrum.h"
#include "tetraction/dynamics/problems/derivative_check.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// An error above this means that the derivatives of a material are wrong, on any mesh.
constexpr double kLargestDerivativeError = 1e-7;
// The least turn in a step that is reported, rad. Vibrations at the start have less.
constexpr double kTurn = 1e-4;

// The scene's own materials first, then the other models with the small-strain response of the
// first.
std::vector<MaterialField> materials_to_check(const std::vector<MaterialField>& own) {
  const LameParameters lame = initial_lame(own.front().model());
  std::vector<MaterialField> models = own;
  for (const MaterialModel& other : materials_like(lame)) {
    const bool there = std::any_of(own.begin(), own.end(), [&](const MaterialField& field) {
      return field.model().index() == other.index();
    });
    if (!there) models.push_back(other);
  }
  return models;
}

// A quantity of the elements of a region: one number, or the least and the largest if they differ.
class Spread {
 public:
  void add(double value) {
    least_ = std::min(least_, value);
    most_ = std::max(most_, value);
  }
  nlohmann::ordered_json json() const {
    if (least_ == most_) return least_;
    return {least_, most_};
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
};

std::string range_text(const nlohmann::ordered_json& value) {
  if (!value.is_array()) return fmt::format("{:.6g}", value.get<double>());
  return fmt::format("{:.6g} to {:.6g}", value[0].get<double>(), value[1].get<double>());
}

nlohmann::ordered_json material_json(const MechanicalSystem& system, Index region,
                                     const std::vector<Index>& elements) {
  Spread mu;
  Spread lambda;
  Spread density;
  Spread pressure_wave;
  Spread shear_wave;
  for (const Index e : elements) {
    const LameParameters lame = system.lame(e);
    mu.add(lame.mu);
    lambda.add(lame.lambda);
    density.add(system.density(e));
    pressure_wave.add(wave_speed(lame, system.density(e)));
    shear_wave.add(std::sqrt(lame.mu / system.density(e)));
  }
  const MaterialField& material = system.materials()[static_cast<std::size_t>(region)];
  return {{"model", material_name(material.model())},
          {"mu", mu.json()},
          {"lambda", lambda.json()},
          {"density", density.json()},
          {"wave_speed", pressure_wave.json()},
          {"shear_wave_speed", shear_wave.json()}};
}

// The rules that have the limit of stability_limit(). With damping each rule has its own.
std::string rules_of_limit(const MechanicalSystem& system, Integrator rule) {
  if (!system.is_dissipative()) return "explicit and verlet";
  return to_string(is_implicit(rule) ? Integrator::kExplicit : rule);
}

// The effect of the rule on a body that turns by this angle, rad, in a step.
std::string turning_text(Integrator rule, double turn) {
  std::string text = fmt::format("{:.3g} rad in a step", turn);
  if (rule == Integrator::kMidpoint) {
    text += fmt::format(
        "; midpoint stretches the body by {:.2g} for that. energy-momentum has no such stretch",
        turn * turn / 8.0);
  }
  return text;
}

// midpoint puts energy into a stiff body that turns far in a step.
std::string turning_warning(Integrator rule, double turn, double step, double critical_step) {
  constexpr double kFar = 0.01;
  constexpr double kStiff = 10.0;
  if (rule != Integrator::kMidpoint || turn < kFar || !(step > kStiff * critical_step)) return {};
  return fmt::format(
      "the body turns by {:.2g} rad in a step that is {:.0f} times its stability limit: the energy "
      "of midpoint may then grow without bound, however small the strains are. Take "
      "time.integrator = \"energy-momentum\", or a smaller time.step",
      turn, step / critical_step);
}

int check(const std::string& path, const std::vector<std::string>& overrides, bool as_json,
          bool with_spectrum) {
  const Scene scene = read_scene(path, overrides);
  if (scene.solver.engine != "local") refuse_what_parts_lack(scene, Analysis::kMotion);
  std::vector<std::string> unused;
  const std::unique_ptr<MechanicalSystem> system =
      make_system(scene, read_scene_mesh(scene, unused));
  const TetMesh& mesh = system->mesh();
  BodyConstraints constraints;
  std::string note;
  const State state = make_initial_state(scene, *system, constraints, note);
  check_events(scene, *system);
  const ProbeSet probes(scene.probe, *system);
  const StabilityLimit limit = stability_limit(*system, state.position, scene.time.integrator);

  const SceneFacts facts = scene_facts(scene, *system, constraints, state.position);

  nlohmann::ordered_json json;
  const std::vector<QualityMeasure> quality = mesh_quality(mesh);
  json["mesh"] = mesh_json(mesh, unused, quality);
  json["mass"] = system->total_mass();
  json["free_degrees_of_freedom"] = system->coordinates().count();
  json["multipliers"] = system->constraints().equation_count();
  json["events"] = scene.event.size();
  json["probes"] = probes.probes().size();
  enter_facts(facts, *system, json);
  double fastest = 0.0;
  json["materials"] = nlohmann::ordered_json::array();
  for (Index r = 0; r < system->region_count(); ++r) {
    const std::vector<Index> elements = system->elements_of(r);
    if (elements.empty()) continue;  // the other regions cover the body
    json["materials"].push_back(material_json(*system, r, elements));
    fastest =
        std::max(fastest, json["materials"].back()["wave_speed"].flatten().back().get<double>());
  }
  json["wave_speed"] = fastest;
  const Vector3 size = bounding_box(mesh).size();
  json["size"] = {size.x(), size.y(), size.z()};
  json["wave_time"] = size.maxCoeff() / fastest;
  json["omega_max"] = limit.omega_max;
  json["stable_step"] = limit.critical_step;
  if (limit.element >= 0) json["stable_step_element"] = mesh.tetrahedron_id(limit.element);

  const double step = scene.time.automatic ? 0.5 * limit.critical_step : scene.time.step;
  const double spin = spin_of(*system, state).norm();
  json["spin"] = spin;
  json["turn_per_step"] = spin * step;
  const Spectrum spectrum = spectrum_of(*system, limit, with_spectrum);
  if (spectrum.lowest) json["lowest_frequency"] = *spectrum.lowest;
  if (spectrum.damping_ratio > 0.0) json["lowest_damping_ratio"] = spectrum.damping_ratio;
  json["highest_frequency"] = spectrum.highest;
  if (with_spectrum) json["spectrum"] = spectrum_json(spectrum, step);

  // Errors of laws that the scene does not use are printed, but do not make the check fail.
  bool exact = true;
  json["derivatives"] = nlohmann::ordered_json::array();
  const auto enter_errors = [&](const DerivativeErrors& errors, const std::string& of,
                                bool is_used) {
    const bool good = errors.force_norm > 0.0 && errors.force < kLargestDerivativeError &&
                      errors.stiffness < kLargestDerivativeError;
    exact = exact && (good || !is_used);
    json["derivatives"].push_back({{"material", of},
                                   {"force_error", errors.force},
                                   {"stiffness_error", errors.stiffness},
                                   {"ok", good}});
  };
  const std::vector<MaterialField> materials = materials_to_check(system->materials());
  ElasticPotential potential(system->rest(), materials.front());
  for (std::size_t i = 0; i < materials.size(); ++i) {
    potential.set_material(0, materials[i]);
    const std::string name = material_name(materials[i].model());
    double energy = 0.0;
    if (!potential.value(state.position, energy).ok()) {
      json["derivatives"].push_back({{"material", name}, {"defined", false}});
      continue;
    }
    const Vector q = strained_state(potential, state.position);
    enter_errors(check_derivatives(potential, q), name, i < system->materials().size());
  }
  if (const NodalVolume* volume = system->nodal_volume(); volume != nullptr) {
    const Vector q = strained_state(system->elastic(), state.position);
    enter_errors(check_derivatives(*volume, system->rest(), q), "nodal volumes", true);
  }
  if (const auto errors = check_contact_derivatives(*system, state.position)) {
    enter_errors(*errors, "contact", true);
  }

  if (as_json) {
    // The name of a file need not be UTF-8, which JSON must be.
    write_json_result(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                      "\n");
  } else {
    print_result("{}: the scene is valid\n\n", path);
    print_mesh_table(mesh, unused, quality);
    write_result("\n");
    for (const auto& material : json["materials"]) {
      print_result(
          "material: {} with mu = {} Pa, lambda = {} Pa at small strain, density {} kg/m3, wave "
          "speeds {} m/s (pressure) and {} m/s (shear)\n",
          material["model"].get<std::string>(), range_text(material["mu"]),
          range_text(material["lambda"]), range_text(material["density"]),
          range_text(material["wave_speed"]), range_text(material["shear_wave_speed"]));
    }
    print_result(
        "size: {:.6g} x {:.6g} x {:.6g} m; a pressure wave takes {:.4g} s along the longest side. "
        "If this is not the body that you mean, see mesh.unit and mesh.scale\n",
        size.x(), size.y(), size.z(), size.maxCoeff() / fastest);
    print_result("mass: {:.6g} kg; {} of {} degrees of freedom free", system->total_mass(),
                 system->coordinates().count(), system->dof_count());
    if (system->constraints().has_equations()) {
      print_result(", {} multipliers", system->constraints().equation_count());
    }
    write_result("\n");
    print_inertia(facts);
    if (limit.element >= 0) {
      print_result(
          "stability limit of {}: h_crit = {:.6g} s (omega_max = {:.6g} rad/s, most at element "
          "{}{})\n",
          rules_of_limit(*system, scene.time.integrator), limit.critical_step, limit.omega_max,
          mesh.tetrahedron_id(limit.element), damping_of_limit(limit));
    } else {
      print_result("stability limit of the explicit rules: none, because every vertex is held\n");
    }
    if (scene.time.automatic && limit.element < 0) {
      print_result("time.step = \"auto\" needs such a limit: give the step in seconds\n");
    } else if (scene.time.automatic) {
      print_result("time.step = \"auto\" takes {:.6g} s\n", 0.5 * limit.critical_step);
    } else if (limit.element < 0) {
      print_result("time.step = {:.6g} s\n", scene.time.step);
    } else if (!is_implicit(scene.time.integrator)) {
      print_result("time.step = {:.6g} s is {:.3g} of it: {}\n", scene.time.step,
                   scene.time.step / limit.critical_step,
                   scene.time.step > limit.critical_step ? "the run will blow up" : "stable");
    } else {
      print_result("time.step = {:.6g} s is {:.3g} times it\n", scene.time.step,
                   scene.time.step / limit.critical_step);
    }
    if (spin * step > kTurn) {
      print_result("spin at the start: {:.4g} rad/s, {}\n", spin,
                   turning_text(scene.time.integrator, spin * step));
    }
    print_resolution(spectrum, scene.time.integrator, step);
    if (with_spectrum) print_spectrum(spectrum, step);
    if (const std::string remarks = damping_remarks(scene); !remarks.empty()) {
      print_result("{}\n", remarks);
    }
    print_loads_and_supports(facts, scene, *system);
    print_result(
        "\nanalytic derivatives against central differences, at the initial state strained by "
        "about 10 %{}:\n{:<16}{:>18}{:>18}\n",
        system->contact() != nullptr ? ", and in the layers of obstacles" : "", "material",
        "forces", "stiffness");
    for (const auto& row : json["derivatives"]) {
      if (row.contains("defined")) {
        print_result("{:<16}{:>36}\n", row["material"].get<std::string>(), "not defined there");
        continue;
      }
      print_result("{:<16}{:>18.2e}{:>18.2e}{}\n", row["material"].get<std::string>(),
                   row["force_error"].get<double>(), row["stiffness_error"].get<double>(),
                   row["ok"].get<bool>() ? "" : "   NOT below 1e-7");
    }
  }
  for (const auto& warning_of : {locking_warning, thin_wall_warning, instability_warning}) {
    if (const std::string warning = warning_of(*system); !warning.empty()) print_warning(warning);
  }
  if (const std::string warning =
          turning_warning(scene.time.integrator, spin * step, step, limit.critical_step);
      !warning.empty()) {
    print_warning(warning);
  }
  for (const std::string& warning : facts.warnings) print_warning(warning);
  if (!spectrum.warning.empty()) print_warning(spectrum.warning);
  if (!exact) print_warning("the derivatives differ from finite differences by more than 1e-7");
  return exact ? 0 : 1;
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string scene;
    std::vector<std::string> overrides;
    bool json = false;
    bool spectrum = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "check",
      "Validate a scene and report mesh quality, mass, stable step and errors of the derivatives");
  command->add_option("scene", arguments->scene, "Scene file (TOML)")->required();
  command->add_option("--set", arguments->overrides, "KEY=VALUE: overrides a scene key")
      ->take_all()
      ->allow_extra_args(false);
  command->add_flag("--json", arguments->json, "Print JSON to stdout");
  command->add_flag("--spectrum", arguments->spectrum,
                    "Say for each integrator what the step does to the lowest and highest modes");
  command->callback([arguments, &exit_code] {
    exit_code = check(arguments->scene, arguments->overrides, arguments->json, arguments->spectrum);
  });
}

}  // namespace tetraction
