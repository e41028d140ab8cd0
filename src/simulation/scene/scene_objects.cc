#include "tetraction/simulation/scene_objects.h"

#include <fmt/format.h>

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "body_constraints.h"
#include "body_loads.h"
#include "body_obstacles.h"
#include "initial_state.h"
#include "setting_keys.h"
#include "simulation/facts/obstacle_checks.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
#include "tetraction/solver/newton_root_finder.h"

namespace tetraction {

TetMesh generate_mesh(const GeneratorSettings& settings) {
  switch (settings.kind) {
    case GeneratorKind::kTetrahedron:
      return generate_tetrahedron(settings.size.x());
    case GeneratorKind::kBeam:
    case GeneratorKind::kBox:
    case GeneratorKind::kCube:
      break;
  }
  return generate_box(settings.size, settings.cells);
}

namespace {

Environment constant_environment(const EnvironmentSettings& settings) {
  switch (settings.kind) {
    case EnvironmentKind::kNone:
      break;
    case EnvironmentKind::kGravity:
      return Environment::uniform(settings.strength * settings.direction);
    case EnvironmentKind::kAttraction:
      return Environment::attraction(settings.strength, settings.softening);
    case EnvironmentKind::kCustom:
      return Environment::custom(settings.field);
  }
  return {};
}

// Material and density of the elements whose region has the number `index`.
BodyRegion make_region(const MaterialSettings& material, const TetMesh& mesh,
                       const std::vector<int>& region_of_element, int index) {
  std::vector<Index> elements;
  for (std::size_t e = 0; e < region_of_element.size() && !material.arrays.empty(); ++e) {
    if (region_of_element[e] == index) elements.push_back(static_cast<Index>(e));
  }
  return {make_material(material, mesh, elements), material.density,
          make_densities(material, mesh, elements)};
}

void set_loads(const Scene& scene, MechanicalSystem& system) {
  BodyLoads loads = make_loads(scene, system, scene.amplitude);
  system.set_forces(std::move(loads.forces));
  system.set_pressures(std::move(loads.pressures));
}

}  // namespace

MaterialField make_material(const MaterialSettings& settings, const MechanicalSystem& system,
                            Index region) {
  if (settings.arrays.empty()) return make_material(settings);
  return make_material(settings, system.mesh(), system.elements_of(region));
}

Environment make_environment(const EnvironmentSettings& settings,
                             const std::vector<AmplitudeSettings>& amplitudes) {
  Environment environment = constant_environment(settings);
  environment.set_amplitude(find_amplitude(amplitudes, settings.amplitude, "[environment]"));
  return environment;
}

std::unique_ptr<MechanicalSystem> make_system(const Scene& scene, TetMesh mesh) {
  std::vector<int> region_of_element(mesh.tetrahedra.size(), 0);
  for (std::size_t i = 0; i < scene.material_region.size(); ++i) {
    const MaterialRegionSettings& region = scene.material_region[i];
    try {
      for (const Index e : select_tetrahedra(mesh, region.select)) {
        region_of_element[static_cast<std::size_t>(e)] = static_cast<int>(i) + 1;
      }
    } catch (const InputError& error) {
      throw InputError(region.where + ": " + error.what());
    }
  }
  std::vector<BodyRegion> regions{make_region(scene.material, mesh, region_of_element, 0)};
  for (const MaterialRegionSettings& region : scene.material_region) {
    regions.push_back(
        make_region(region.material, mesh, region_of_element, static_cast<int>(regions.size())));
  }
  auto system = std::make_unique<MechanicalSystem>(std::move(mesh), regions, region_of_element,
                                                   scene.mesh.volume);
  put_sections(scene, *system, scene.amplitude);
  set_loads(scene, *system);
  const std::optional<BodyContact> between = body_contact(scene.contact, *system);
  if (between || may_touch_obstacles(scene)) {
    system->set_contact(make_contact(initial_obstacles(scene, *system), scene.amplitude, *system,
                                     nullptr, between));
  }
  move_contact_masses(scene, *system);
  for (const auto& term : scene.force_term) system->add_force_term(term);
  return system;
}

void use_consistent_weights(const Scene& scene, MechanicalSystem& system) {
  system.use_consistent_weights();
  set_loads(scene, system);
}

namespace {

// Selections refer to the undeformed body, and arrays belong to its mesh. So errors in the selections
// and the arrays of edits are found before the run.
struct SelectionCheck {
  const MechanicalSystem& system;
  const std::vector<AmplitudeSettings>& amplitudes;
  const Scene& scene;

  void operator()(const SetMaterial& edit) const {
    const auto region = static_cast<std::size_t>(edit.region);
    if (edit.region < 0 || region > scene.material_region.size()) return;  // the edit is refused
    const MaterialSettings& now =
        region == 0 ? scene.material : scene.material_region[region - 1].material;
    if (density_array(edit.material) != density_array(now)) {
      throw InputError("material.density cannot change during a run.");
    }
    const MaterialField material = make_material(edit.material, system, edit.region);
    if (system.nodal_volume() != nullptr) NodalVolume::without_volumetric_part(material);
  }

  void operator()(const SetForce& edit) const { check_load(edit.entry, system, amplitudes); }
  void operator()(const SetEnvironment& edit) const { make_environment(edit.settings, amplitudes); }
  void operator()(const SetPull& edit) const { make_pull(edit.settings, system); }
  void operator()(const SetFix& edit) const {
    make_held(edit.entry, system.mesh(), system.mesh().rest_positions(), 0.0, amplitudes);
  }
  void operator()(const Unfix& edit) const { select_at(system.mesh(), edit.select, edit.where); }
  void operator()(const SetConstraint& edit) const {
    make_constraint(edit.entry, system, system.mesh().rest_positions(), 0.0, amplitudes);
  }
  void operator()(const SetObstacle& edit) const {
    make_contact({begun_obstacle(edit.entry, 0.0, 1.0)}, amplitudes, system);
  }
  void operator()(const ShiftState& edit) const { check_shift(edit.change, system.mesh()); }
  template <class Change>
  void operator()(const ChangeState<Change>& edit) const {
    if constexpr (requires { edit.change.select; }) {
      select_at(system.mesh(), edit.change.select, edit.change.where);
    }
  }
  template <class Other>
  void operator()(const Other&) const {}
};

// Checks the integrator, the solver and the pull at the start and those that each event leaves.
void check_solvers(const Scene& scene, const MechanicalSystem& system) {
  Integrator integrator = scene.time.integrator;
  SolverSettings solver = scene.solver;
  const PullSettings* pulled = nullptr;  // that of the last event that changes it
  check_solver(integrator, solver, system);
  for (const EventSettings& event : scene.event) {
    bool changed = false;
    for (const Edit& edit : event.edits) {
      if (const auto* time = std::get_if<SetTime>(&edit)) {
        integrator = time->settings.integrator;
        changed = true;
      } else if (const auto* set = std::get_if<SetSolver>(&edit)) {
        solver = set->settings;
        changed = true;
      } else if (const auto* pull = std::get_if<SetPull>(&edit)) {
        pulled = &pull->settings;
        changed = true;
      }
    }
    if (!changed) continue;
    try {
      check_solver(integrator, solver, system);
      if (pulled != nullptr && is_implicit(integrator) && solver.kind == "ceres") {
        check_ceres(make_pull(*pulled, system));
      }
    } catch (const InputError& error) {
      if (event.where.empty()) throw;
      throw InputError(fmt::format("{}: {}", event.where, error.what()));
    }
  }
}

}  // namespace

std::string density_array(const MaterialSettings& material) {
  const auto found = material.arrays.find(kDensity.name);
  return found == material.arrays.end() ? std::string() : found->second;
}

void check_events(const Scene& scene, const MechanicalSystem& system) {
  check_obstacle_names(scene);
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const SelectionCheck check{system, scene.amplitude, scene};
      try {
        std::visit(check, edit);
      } catch (const InputError& error) {
        // The place of a material is that of its section, which the event has changed, and a pull has none.
        const bool is_placed =
            !std::holds_alternative<SetMaterial>(edit) && !std::holds_alternative<SetPull>(edit);
        if (is_placed || event.where.empty()) throw;
        throw InputError(fmt::format("{}: {}", event.where, error.what()));
      }
    }
  }
  check_solvers(scene, system);
  refuse_contradicting_targets(scene, system);
}

std::vector<Index> check_shift(const ShiftSettings& shift, const TetMesh& mesh) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format("{}{}{}", shift.where, shift.where.empty() ? "" : ": ", what));
  };
  const std::size_t count = shift.vertices.size();
  for (const auto* list : {&shift.displacement, &shift.impulse}) {
    if (!list->empty() && list->size() != count) {
      refuse(fmt::format(
          "displacement and impulse need one entry for each of the {} vertices, or none at all.",
          count));
    }
    for (const Vector3& value : *list) {
      if (!value.allFinite()) refuse("displacement and impulse must be finite.");
    }
  }
  if (shift.displacement.empty() && shift.impulse.empty()) {
    refuse("neither a displacement nor an impulse is given.");
  }
  // The selection is sorted and has no repeats. The order of the shift is found by the numbers.
  const std::vector<Index> sorted = select_at(mesh, SelectVertices{shift.vertices}, shift.where);
  if (sorted.size() != count) refuse("a vertex comes twice; give each once.");
  std::unordered_map<std::int64_t, Index> index_of;
  for (const Index v : sorted) index_of.emplace(mesh.vertex_id(v), v);
  std::vector<Index> vertices;
  vertices.reserve(count);
  for (const std::int64_t id : shift.vertices) vertices.push_back(index_of.at(id));
  return vertices;
}

void check_solver(Integrator integrator, const SolverSettings& solver,
                  const MechanicalSystem& system) {
  check_settings(solver);
  if (!is_implicit(integrator)) {
    if (!system.has_moved_masses()) return;
    throw InputError(fmt::format(
        "contact.mass is for implicit steps, but time.integrator is \"{}\", whose steps would have "
        "to be as short as light vertices make them: take an implicit integrator, or leave "
        "contact.mass out.",
        to_string(integrator)));
  }
  if (needs_root_finder(integrator) && solver.kind != "newton") {
    throw InputError(
        fmt::format("solver.kind = \"{}\" minimises, but a step of integrator = \"{}\" is no "
                    "minimisation: take solver.kind = \"newton\", or integrator = \"midpoint\".",
                    solver.kind, to_string(integrator)));
  }
  if (solver.kind == "ceres" && system.contact() != nullptr &&
      system.contact()->between() != nullptr) {
    throw InputError(
        "Ceres cannot take contact.between, which couples vertices that belong to no common "
        "tetrahedron: set solver.kind = \"newton\", or contact.between = \"none\".");
  }
  if (solver.kind == "ceres") check_ceres(system);
  if (system.contact() == nullptr || solver.kind == "newton") return;
  if (integrator == Integrator::kMidpoint) {
    throw InputError(fmt::format(
        "solver.kind = \"{}\" minimises, but a midpoint step with [[obstacle]] is no minimisation: "
        "take solver.kind = \"newton\", or integrator = \"backward-euler\".",
        solver.kind));
  }
  if (system.contact()->has_friction()) {
    throw InputError(fmt::format(
        "solver.kind = \"{}\" minimises, but a step with friction is no minimisation: take "
        "solver.kind = \"newton\", or friction = 0.",
        solver.kind));
  }
}

namespace {

NewtonOptions newton_options(const SolverSettings& solver) {
  NewtonOptions options;
  options.tolerance = solver.tolerance;
  options.max_iterations = solver.max_iterations;
  options.linear = solver.linear;
  return options;
}

}  // namespace

std::unique_ptr<Minimizer> make_minimizer(const SolverSettings& solver,
                                          const MechanicalSystem& system) {
  check_settings(solver);
  if (solver.kind == "newton") return make_newton_minimizer(system, newton_options(solver));
  return make_ceres_minimizer(system, {solver.tolerance, solver.max_iterations});
}

std::unique_ptr<RootFinder> make_root_finder(const SolverSettings& solver,
                                             const MechanicalSystem& system) {
  // A body in parts has no rule yet that needs one.
  if (solver.kind != "newton" || system.part() != nullptr) return nullptr;
  return make_newton_krylov_root_finder(system, newton_options(solver));
}

std::unique_ptr<Stepper> make_stepper(Integrator integrator, const SolverSettings& solver,
                                      const MechanicalSystem& system) {
  // An implicit step solves three linear systems for each equation, and a dense one for all together.
  constexpr Index kMostEquations = 1000;
  const Index equations = system.constraints().equation_count();
  if (is_implicit(integrator) && equations > kMostEquations) {
    throw InputError(
        fmt::format("The distances and rigid handles have {} equations together, but implicit "
                    "steps take {} at most: take integrator = \"verlet\" or \"explicit\", or one "
                    "constraint of kind \"rigid\" for vertices that keep all their distances.",
                    equations, kMostEquations));
  }
  check_solver(integrator, solver, system);
  std::shared_ptr<Minimizer> minimizer;
  std::shared_ptr<RootFinder> root_finder;
  if (is_implicit(integrator)) {
    minimizer = make_minimizer(solver, system);
    root_finder = make_root_finder(solver, system);
  }
  return make_stepper(integrator, system, std::move(minimizer), std::move(root_finder));
}

}  // namespace tetraction
