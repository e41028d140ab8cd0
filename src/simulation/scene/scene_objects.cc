#include "tetraction/simulation/scene_objects.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "body_constraints.h"
#include "body_loads.h"
#include "contradicting_targets.h"
#include "initial_state.h"
#include "shared_error.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/setting_keys.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"
#include "tetraction/solver/newton_root_finder.h"

namespace tetraction {
namespace {

// A point-data array with three components, as a DOF-ordered field.
Vector point_array(const TetMesh& mesh, const std::string& name, const char* key) {
  const auto found = mesh.point_arrays.find(name);
  if (found == mesh.point_arrays.end() || found->second.rows() != 3) {
    std::string known;
    for (const auto& [array, values] : mesh.point_arrays) {
      if (values.rows() == 3) known += (known.empty() ? "" : ", ") + array;
    }
    throw InputError(std::string("initial.") + key + " = \"" + name + "\": " + mesh.source +
                     " has no point-data array of that name with 3 components; it has " +
                     (known.empty() ? "none" : known) + ".");
  }
  Vector field = found->second.reshaped();
  if (!field.allFinite()) {
    throw InputError(std::string("initial.") + key + " = \"" + name +
                     "\": the array holds a value that is not finite.");
  }
  return field;
}

// The field of [initial] that the mesh's reader has put under a name.
Vector initial_field(const TetMesh& mesh, const FieldSettings& field, const char* name) {
  const auto found = mesh.point_arrays.find(name);
  if (found == mesh.point_arrays.end() || found->second.rows() != 3 ||
      found->second.cols() != mesh.vertex_count()) {
    throw InputError(
        fmt::format("{}{}{} is a field whose values the mesh does not have: make the mesh with "
                    "read_scene_mesh(), or take {}_array with values of your own.",
                    field.where, field.where.empty() ? "" : ": ", name, name));
  }
  return found->second.reshaped();
}

// Throws InputError if the displacement by a key of [initial] has inverted an element.
void check_inversion(const Scene& scene, const MechanicalSystem& system, const Vector& position,
                     const std::string& key) {
  const EvaluationStatus status = system.elastic().admissible(position);
  if (status.ok()) return;
  const auto place = scene.initial.places.find(key);
  throw InputError(fmt::format("{}{}initial.{} inverts element {}: make it smaller.",
                               place == scene.initial.places.end() ? "" : place->second,
                               place == scene.initial.places.end() ? "" : ": ", key,
                               system.mesh().tetrahedron_id(status.failed_element)));
}

// The positions that the keys of [initial] give. Throws InputError if `checked` and one of them inverts
// an element.
Vector initial_positions(const Scene& scene, const MechanicalSystem& system, bool checked) {
  Vector position = system.mesh().rest_positions();
  const auto check = [&](const char* key) {
    if (checked) check_inversion(scene, system, position, key);
  };
  const Vector3 center = center_of_mass(system, position);
  const Vector3& stretch = scene.initial.stretch;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    // A component that is not stretched stays bitwise unchanged.
    for (Index i = 0; i < 3; ++i) {
      if (stretch[i] == 1.0) continue;
      position[3 * v + i] = center[i] + stretch[i] * (position[3 * v + i] - center[i]);
    }
  }
  check("stretch");
  const InitialSettings& initial = scene.initial;
  if (!initial.displacement_field.empty()) {
    position += initial_field(system.mesh(), initial.displacement_field, kInitialDisplacement);
    check("displacement");
  } else if (!initial.displacement.isZero(0.0)) {
    position += initial.displacement.replicate(system.vertex_count(), 1);
  }
  if (!initial.displacement_array.empty()) {
    position += point_array(system.mesh(), initial.displacement_array, "displacement_array");
    check("displacement_array");
  }
  return position;
}

}  // namespace

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
  system->set_environment(make_environment(scene.environment, scene.amplitude));
  system->set_damping(scene.damping);
  set_loads(scene, *system);
  for (const auto& term : scene.force_term) system->add_force_term(term);
  return system;
}

void use_consistent_weights(const Scene& scene, MechanicalSystem& system) {
  system.use_consistent_weights();
  set_loads(scene, system);
}

void require_defined_terms(const MechanicalSystem& system, const Vector& position, double time,
                           const std::string& what) {
  Index vertex = -1;
  const ForceTerm* term = system.undefined_term(position, time, vertex);
  if (term == nullptr) return;
  if (vertex < 0) {
    throw InputError(fmt::format("{}: the potential of the force term \"{}\" is not finite there.",
                                 what, term->name()));
  }
  throw InputError(fmt::format(
      "{} puts vertex {} to where the potential of the force term \"{}\" is not defined: move the "
      "body away from there.",
      what, system.mesh().vertex_id(vertex), term->name()));
}

namespace {

// Makes the constraints and moves `position` so that it satisfies them. Throws InputError.
Constraints make_constraints(const MechanicalSystem& system, const BodyConstraints& constraints,
                             double time, Vector& position) {
  Constraints next(constraints.list(), system.mesh(), system.mass());
  if (const std::string failed = project_positions(next, time, position); !failed.empty()) {
    throw InputError(failed +
                     ": cannot be met together with the other constraints on its vertices. Change "
                     "the length, or leave one of them out.");
  }
  return next;
}

}  // namespace

void set_constraints_of_equilibrium(const Scene& scene, MechanicalSystem& system,
                                    BodyConstraints& constraints) {
  Vector position = initial_positions(scene, system, false);
  constraints = make_body_constraints(scene, system, position);
  system.set_constraints(make_constraints(system, constraints, 0.0, position));
}

Constraints constrain(MechanicalSystem& system, const BodyConstraints& constraints, double time,
                      Vector& position, const char* advice) {
  Vector moved = position;
  std::optional<Constraints> next;
  do_in_all_parts(system.part(), [&] {
    next = make_constraints(system, constraints, time, moved);
    if (const EvaluationStatus status = system.elastic().admissible(moved); !status.ok()) {
      throw InputError(fmt::format(
          "Moving the vertices to where the constraints hold them inverts element {}: {}",
          system.mesh().tetrahedron_id(status.failed_element), advice));
    }
    require_defined_terms(system, moved, time,
                          "Moving the vertices to where the constraints hold them");
  });
  position = moved;  // a copy, so that the vector keeps its address
  return system.set_constraints(std::move(*next));
}

namespace {

// The positions of the equilibrium under the loads at t = 0.
Vector static_positions(const Scene& scene, const MechanicalSystem& system, std::string& note) {
  Equilibrium equilibrium = find_equilibrium(system, scene.solver, 0.0);
  if (!equilibrium.found) {
    throw NumericalError(
        "initial.static = true: there is no equilibrium to start from: " + equilibrium.message +
        ". Make the loads smaller, or let tetraction static show how far they go.");
  }
  if (!equilibrium.message.empty()) note = "initial.static: " + equilibrium.message;
  return std::move(equilibrium.position);
}

void set_initial_velocity(const Scene& scene, const MechanicalSystem& system, State& state) {
  const InitialSettings& initial = scene.initial;
  const Vector3 center = center_of_mass(system, state.position);
  Vector velocity(system.dof_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(std::as_const(state.position), v) - center;
    vertex_block(velocity, v) = initial.velocity + initial.angular_velocity.cross(arm);
  }
  if (!initial.velocity_field.empty()) {
    velocity += initial_field(system.mesh(), initial.velocity_field, kInitialVelocity);
  }
  if (!initial.velocity_array.empty()) {
    velocity += point_array(system.mesh(), initial.velocity_array, "velocity_array");
  }
  for (const MomentumSettings& momentum : initial.momentum) {
    for (const Index v : select_at(system.mesh(), momentum.select, momentum.where)) {
      vertex_block(velocity, v) = momentum.value / system.mass()[v];
    }
  }
  system.set_velocity(state, velocity);
}

}  // namespace

State make_initial_state(const Scene& scene, MechanicalSystem& system) {
  BodyConstraints constraints;
  std::string note;
  return make_initial_state(scene, system, constraints, note);
}

State make_initial_state(const Scene& scene, MechanicalSystem& system, BodyConstraints& constraints,
                         std::string& note) {
  const InitialSettings& initial = scene.initial;
  State state = system.rest_state();
  if (initial.is_static) {
    set_constraints_of_equilibrium(scene, system, constraints);
    state.position = static_positions(scene, system, note);
    set_initial_velocity(scene, system, state);
    return state;
  }
  state.position = initial_positions(scene, system, false);
  if (!everywhere(system.part(), system.elastic().admissible(state.position).ok())) {
    initial_positions(scene, system, true);
  }
  require_defined_terms(system, state.position, 0.0, "The initial state");
  constraints = make_body_constraints(scene, system, state.position);
  constrain(system, constraints, state.time, state.position,
            "bring the targets of [[fix]] and [[constraint]] nearer, or take a smaller "
            "initial.stretch or displacement.");
  set_initial_velocity(scene, system, state);
  return state;
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

  void operator()(const SetForce& edit) const { check_load(edit.force, system, amplitudes); }
  void operator()(const SetEnvironment& edit) const {
    make_environment(edit.environment, amplitudes);
  }
  void operator()(const SetFix& edit) const {
    make_held(edit.fix, system.mesh(), system.mesh().rest_positions(), 0.0, amplitudes);
  }
  void operator()(const Unfix& edit) const { select_at(system.mesh(), edit.select, edit.where); }
  void operator()(const SetConstraint& edit) const {
    make_constraint(edit.constraint, system, system.mesh().rest_positions(), 0.0, amplitudes);
  }
  void operator()(const ShiftState& edit) const { check_shift(edit.shift, system.mesh()); }
  void operator()(const SetMomentum& edit) const {
    select_at(system.mesh(), edit.momentum.select, edit.momentum.where);
  }
  template <class Other>
  void operator()(const Other&) const {}
};

// Checks the integrator and the solver that each event leaves.
void check_solvers_of_events(const Scene& scene, const MechanicalSystem& system) {
  Integrator integrator = scene.time.integrator;
  SolverSettings solver = scene.solver;
  for (const EventSettings& event : scene.event) {
    bool changed = false;
    for (const Edit& edit : event.edits) {
      if (const auto* time = std::get_if<SetTime>(&edit)) {
        integrator = time->time.integrator;
        changed = true;
      } else if (const auto* set = std::get_if<SetSolver>(&edit)) {
        solver = set->solver;
        changed = true;
      }
    }
    if (!changed) continue;
    try {
      check_solver(integrator, solver, system);
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
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      const SelectionCheck check{system, scene.amplitude, scene};
      try {
        std::visit(check, edit);
      } catch (const InputError& error) {
        // The place of a material is that of its section, which the event has changed.
        if (!std::holds_alternative<SetMaterial>(edit) || event.where.empty()) throw;
        throw InputError(fmt::format("{}: {}", event.where, error.what()));
      }
    }
  }
  check_solvers_of_events(scene, system);
  refuse_contradicting_targets(scene, system);
}

std::vector<Index> check_shift(const ShiftSettings& shift, const TetMesh& mesh) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format("{}{}{}", shift.where, shift.where.empty() ? "" : ": ", what));
  };
  const std::size_t count = shift.vertices.size();
  for (const auto* list : {&shift.displacement, &shift.impulse}) {
    if (!list->empty() && list->size() != count) {
      refuse(
          fmt::format("displacement and impulse need one entry for each of the {} vertices, or "
                      "none at all.",
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
  if (!is_implicit(integrator)) return;
  if (needs_root_finder(integrator) && solver.kind != "newton") {
    throw InputError(fmt::format(
        "solver.kind = \"{}\" minimises, but a step of integrator = \"{}\" is no minimisation: "
        "take solver.kind = \"newton\", or integrator = \"midpoint\".",
        solver.kind, to_string(integrator)));
  }
  if (solver.kind == "ceres") check_ceres(system);
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
  // What needs one is not for a body in parts yet.
  if (solver.kind != "newton" || system.part() != nullptr) return nullptr;
  return make_newton_krylov_root_finder(system, newton_options(solver));
}

std::unique_ptr<Stepper> make_stepper(Integrator integrator, const SolverSettings& solver,
                                      const MechanicalSystem& system) {
  // An implicit step solves three linear systems for each equation, and a dense one for all together.
  constexpr Index kMostEquations = 1000;
  const Index equations = system.constraints().equation_count();
  if (is_implicit(integrator) && equations > kMostEquations) {
    throw InputError(fmt::format(
        "The distances and rigid handles have {} equations together, but implicit steps take {} at "
        "most: take integrator = \"verlet\" or \"explicit\", or one constraint of kind \"rigid\" "
        "for "
        "vertices that keep all their distances.",
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
