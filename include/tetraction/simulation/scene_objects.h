// From a scene to the objects that are stepped.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/stepper.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The mesh that the scene's generator makes. Throws InputError without one or for bad sizes.
TetMesh generate_mesh(const GeneratorSettings& settings);

/// Body, environment, damping and forces of a scene on its mesh; not its constraints, which begin
/// with the initial state. Keeps the mesh as MechanicalSystem does. Throws InputError for selections
/// that select nothing, wrong parameters.
std::unique_ptr<MechanicalSystem> make_system(const Scene& scene, TetMesh mesh);

/// The initial state, with the scene's constraints set in `system`: stretch about the centre of
/// mass, then the displacement array, then vertices to where the constraints hold them; velocities
/// at these positions (v + ω × (q − centre of mass), the velocity array, single momenta), less what
/// the constraints do not allow.
/// Throws InputError for unknown arrays, selections that select nothing, constraints that contradict
/// each other or hold everything, and an initial state in which an element is inverted.
State make_initial_state(const Scene& scene, MechanicalSystem& system);

/// What can be known of the scene's events before the run: throws InputError for selections that
/// select nothing and constraints that make no sense.
void check_events(const Scene& scene, const MechanicalSystem& system);

/// The stepper of an integrator with its solver. Throws InputError for a solver it does not know.
std::unique_ptr<Stepper> make_stepper(Integrator integrator, const SolverSettings& solver,
                                      const MechanicalSystem& system);

}  // namespace tetraction
