#include "tetraction/simulation/scene_objects.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/core/error.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/solver/ceres_minimizer.h"

namespace tetraction {
namespace {

// Selections of a scene, with the place in the scene in front of what may be wrong with them.
std::vector<Index> select_at(const TetMesh& mesh, const Selection& selection,
                             const std::string& where) {
  try {
    return select_vertices(mesh, selection);
  } catch (const InputError& error) {
    throw InputError(where.empty() ? error.what() : where + ": " + error.what());
  }
}

DofConstraints make_constraints(const Scene& scene, const TetMesh& mesh) {
  std::vector<std::uint8_t> fixed(3 * mesh.vertices.size(), 0);
  for (const FixSettings& fix : scene.fix) {
    for (const Index v : select_at(mesh, fix.select, fix.where)) {
      for (Index i = 0; i < 3; ++i) {
        if (fix.components[static_cast<std::size_t>(i)])
          fixed[static_cast<std::size_t>(3 * v + i)] = 1;
      }
    }
  }
  return DofConstraints(std::move(fixed));
}

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

void move_to_targets(const Scene& scene, const TetMesh& mesh, Vector& position) {
  const Vector start = position;
  std::vector<std::uint8_t> placed(static_cast<std::size_t>(position.size()), 0);
  for (const FixSettings& fix : scene.fix) {
    for (const Index v : select_at(mesh, fix.select, fix.where)) {
      for (Index i = 0; i < 3; ++i) {
        if (!fix.components[static_cast<std::size_t>(i)]) continue;
        const Index dof = 3 * v + i;
        double target = start[dof];
        if (fix.target) target = (*fix.target)[i];
        if (fix.offset) target += (*fix.offset)[i];
        auto& done = placed[static_cast<std::size_t>(dof)];
        if (done != 0 && position[dof] != target) {
          throw InputError(
              fix.where + ": vertex " +
              std::to_string(mesh.vertex_ids[static_cast<std::size_t>(v)]) +
              " is fixed twice, to different targets. Let only one [[fix]] select it.");
        }
        done = 1;
        position[dof] = target;
      }
    }
  }
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

std::unique_ptr<MechanicalSystem> make_system(const Scene& scene, const TetMesh& mesh) {
  auto system = std::make_unique<MechanicalSystem>(mesh, make_material(scene.material),
                                                   scene.material.density);
  system->set_constraints(make_constraints(scene, mesh));
  if (scene.environment.kind == EnvironmentKind::kGravity) {
    system->set_environment(Environment(scene.environment.strength * scene.environment.direction));
  }
  for (const ForceSettings& force : scene.force) {
    system->add_force(
        {select_at(mesh, force.select, force.where), force.vector, force.from, force.until});
  }
  return system;
}

State make_initial_state(const Scene& scene, const MechanicalSystem& system) {
  const TetMesh& mesh = system.mesh();
  const InitialSettings& initial = scene.initial;
  State state = system.rest_state();

  const Vector3 rest_center = system.center_of_mass(state.position);
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(std::as_const(state.position), v) - rest_center;
    // A component that is not stretched stays bitwise what it was.
    for (Index i = 0; i < 3; ++i) {
      if (initial.stretch[i] != 1.0) {
        state.position[3 * v + i] = rest_center[i] + initial.stretch[i] * arm[i];
      }
    }
  }
  if (!initial.displacement_array.empty()) {
    state.position += point_array(mesh, initial.displacement_array, "displacement_array");
  }
  move_to_targets(scene, mesh, state.position);

  const Vector3 center = system.center_of_mass(state.position);
  Vector velocity(system.dof_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(std::as_const(state.position), v) - center;
    vertex_block(velocity, v) = initial.velocity + initial.angular_velocity.cross(arm);
  }
  if (!initial.velocity_array.empty()) {
    velocity += point_array(mesh, initial.velocity_array, "velocity_array");
  }
  for (const MomentumSettings& momentum : initial.momentum) {
    for (const Index v : select_at(mesh, momentum.select, momentum.where)) {
      vertex_block(velocity, v) = momentum.value / system.mass()[v];
    }
  }
  system.set_velocity(state, velocity);

  if (const Evaluation status = system.elastic().admissible(state.position); !status.ok()) {
    throw InputError(
        "The initial state inverts element " +
        std::to_string(mesh.tetrahedron_ids[static_cast<std::size_t>(status.failed_element)]) +
        ": make initial.stretch, the initial displacement or the targets of [[fix]] smaller.");
  }
  return state;
}

std::unique_ptr<Stepper> make_stepper(const Scene& scene, const MechanicalSystem& system) {
  switch (scene.time.integrator) {
    case Integrator::kExplicit:
      return make_explicit_stepper(system);
    case Integrator::kVerlet:
      return make_verlet_stepper(system);
    case Integrator::kMidpoint:
    case Integrator::kBackwardEuler:
      break;
  }
  std::shared_ptr<Minimizer> minimizer =
      make_ceres_minimizer(system, {scene.solver.tolerance, scene.solver.max_iterations});
  return scene.time.integrator == Integrator::kMidpoint
             ? make_midpoint_stepper(system, std::move(minimizer))
             : make_backward_euler_stepper(system, std::move(minimizer));
}

}  // namespace tetraction
