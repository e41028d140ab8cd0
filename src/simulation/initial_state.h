// The parts of scene_objects.h that a session needs on its own.
#pragma once

#include "body_constraints.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

/// As in scene_objects.h, and keeps the constraints for later edits.
State make_initial_state(const Scene& scene, MechanicalSystem& system,
                         BodyConstraints& constraints);

/// Gives the system these constraints and moves `position` to where they hold it; returns those it
/// had before. Throws InputError and leaves both as they were if they contradict each other or an
/// element would be inverted.
Constraints constrain(MechanicalSystem& system, const BodyConstraints& constraints, double time,
                      Vector& position);

/// Throws InputError, which begins with `what`, if the potential of a force term is not defined there.
void require_defined_terms(const MechanicalSystem& system, const Vector& position, double time,
                           const std::string& what);

ExternalForce make_force(const ForceSettings& force, const TetMesh& mesh);

/// The vertices of a shift, in its order. Throws InputError for numbers that are not there or come
/// twice, lists of other lengths, values that are not finite.
std::vector<Index> check_shift(const ShiftSettings& shift, const TetMesh& mesh);

/// Throws InputError for settings that no implicit step could work with.
void check_solver(const SolverSettings& solver);

}  // namespace tetraction
