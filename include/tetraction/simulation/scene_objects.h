// From a scene to the objects that are stepped.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The mesh that the scene's generator makes. Throws InputError without one or for bad sizes.
TetMesh generate_mesh(const GeneratorSettings& settings);

/// The material of the settings in a region of the system. Throws InputError as make_material() does
/// for settings and a mesh (scene.h).
MaterialField make_material(const MaterialSettings& settings, const MechanicalSystem& system,
                            Index region);

/// The name of the array that gives the density; empty if it is a number.
std::string density_array(const MaterialSettings& material);

/// The environment of the settings, with an amplitude of the list if they name one. Throws
/// InputError for a custom one without a field, and for an unknown amplitude.
Environment make_environment(const EnvironmentSettings& settings,
                             const std::vector<AmplitudeSettings>& amplitudes = {});

/// Makes the body of a scene on its mesh, with environment, damping and loads. Its constraints are
/// set later, by make_initial_state(). Keeps the mesh as MechanicalSystem does. Throws InputError
/// for selections that select nothing and for wrong parameters.
std::unique_ptr<MechanicalSystem> make_system(const Scene& scene, TetMesh mesh);

/// Lets gravity and the loads of a scene act on the body that make_system() has made of it with
/// consistent weights (MechanicalSystem::use_consistent_weights()). Statics and the modes about an
/// equilibrium have them; the start of a motion has the lumped masses of its time steps.
void use_consistent_weights(const Scene& scene, MechanicalSystem& system);

/// Sets the scene's constraints in `system` and returns the initial state. Positions are made in
/// this order: the stretch about the centre of mass, the displacement array, the positions that the
/// constraints prescribe. Velocities at these positions are v + ω × (q − centre of mass), the
/// velocity array and single momenta, minus the parts that the constraints do not allow. Throws
/// InputError for unknown arrays, selections that select nothing, constraints that contradict each
/// other or hold everything, and an initial state in which an element is inverted.
State make_initial_state(const Scene& scene, MechanicalSystem& system);

/// Checks what can be checked of the scene's events before the run. Throws InputError for
/// selections that select nothing, for constraints with impossible values, and as check_solver() does.
void check_events(const Scene& scene, const MechanicalSystem& system);

/// Throws InputError if steps of the integrator cannot be computed with this solver: the settings are
/// wrong, the solver minimises and the step is no minimisation, or the body has a term that the solver
/// cannot take.
void check_solver(Integrator integrator, const SolverSettings& solver,
                  const MechanicalSystem& system);

/// Makes the solver of the settings. Throws InputError for an unknown one.
std::unique_ptr<Minimizer> make_minimizer(const SolverSettings& solver,
                                          const MechanicalSystem& system);

/// Makes the solver of equations that are not those of a minimum. Null for solver.kind = "ceres", which
/// minimises only.
std::unique_ptr<RootFinder> make_root_finder(const SolverSettings& solver,
                                             const MechanicalSystem& system);

/// Makes the stepper of an integrator with its solver. Throws InputError for an unknown solver.
std::unique_ptr<Stepper> make_stepper(Integrator integrator, const SolverSettings& solver,
                                      const MechanicalSystem& system);

}  // namespace tetraction
