#include "initial_state.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <utility>

#include "body_constraints.h"
#include "mesh/shared_error.h"
#include "setting_keys.h"
#include "simulation/facts/obstacle_checks.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/fem/step_length.h"
#include "tetraction/mesh/mesh_copies.h"
#include "tetraction/simulation/equilibrium.h"

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
  throw InputError(
      fmt::format("{}{}initial.{} {}: make it smaller.",
                  place == scene.initial.places.end() ? "" : place->second,
                  place == scene.initial.places.end() ? "" : ": ", key,
                  inadmissible_change(system.elastic(), position, status.failed_element,
                                      system.mesh().tetrahedron_id(status.failed_element))));
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

// The velocities of rigid bodies: that of [initial] of the whole body or, if the mesh has copies, of the mesh itself,
// and those of the copies.
Vector rigid_velocities(const Scene& scene, const MechanicalSystem& system,
                        const Vector& position) {
  const InitialSettings& initial = scene.initial;
  const std::vector<MeshCopySettings>& copies = scene.mesh.copies;
  Vector velocity(system.dof_count());
  if (copies.empty()) {
    const Vector3 center = center_of_mass(system, position);
    for (Index v = 0; v < system.vertex_count(); ++v) {
      const Vector3 arm = vertex_block(position, v) - center;
      vertex_block(velocity, v) = initial.velocity + initial.angular_velocity.cross(arm);
    }
    return velocity;
  }
  for (std::size_t k = 0; k <= copies.size(); ++k) {
    const std::vector<Index> vertices =
        select_vertices(system.mesh(), SelectGroup{group_of_copy(k)});
    Vector3 center = Vector3::Zero();
    double mass = 0.0;
    for (const Index v : vertices) {
      center += system.mass()[v] * vertex_block(position, v);
      mass += system.mass()[v];
    }
    center /= mass;
    const Vector3& of_all = k == 0 ? initial.velocity : copies[k - 1].velocity;
    const Vector3& spin = k == 0 ? initial.angular_velocity : copies[k - 1].angular_velocity;
    for (const Index v : vertices) {
      vertex_block(velocity, v) = of_all + spin.cross(vertex_block(position, v) - center);
    }
  }
  return velocity;
}

void set_initial_velocity(const Scene& scene, const MechanicalSystem& system, State& state) {
  const InitialSettings& initial = scene.initial;
  Vector velocity = rigid_velocities(scene, system, state.position);
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

void require_defined_terms(const MechanicalSystem& system, const Vector& position, double time,
                           const std::string& what) {
  refuse_penetration(system, position, time, what);
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
      throw InputError(
          fmt::format("Moving the vertices to where the constraints hold them {}: {}",
                      inadmissible_change(system.elastic(), moved, status.failed_element,
                                          system.mesh().tetrahedron_id(status.failed_element)),
                      advice));
    }
    require_defined_terms(system, moved, time,
                          "Moving the vertices to where the constraints hold them");
  });
  position = moved;  // a copy, so that the vector keeps its address
  return system.set_constraints(std::move(*next));
}

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

}  // namespace tetraction
