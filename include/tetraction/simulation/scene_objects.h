// From a scene to the objects that are stepped.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/stepper.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The mesh that the scene's generator makes. Throws InputError without one or for bad sizes.
TetMesh generate_mesh(const GeneratorSettings& settings);

/// Body, constraints, environment and forces of a scene on its mesh.
/// Throws InputError for selections that select nothing, everything fixed, wrong parameters.
std::unique_ptr<MechanicalSystem> make_system(const Scene& scene, const TetMesh& mesh);

/// The initial state: stretch about the centre of mass, then the displacement array, then fixed
/// vertices to their targets; velocities at these positions (v + ω × (q − centre of mass), the
/// velocity array, single momenta), zero for fixed DOFs.
/// Throws InputError for unknown arrays, vertices fixed twice to different targets, and an initial
/// state in which an element is inverted.
State make_initial_state(const Scene& scene, const MechanicalSystem& system);

/// The stepper of the scene's integrator with its solver.
std::unique_ptr<Stepper> make_stepper(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
