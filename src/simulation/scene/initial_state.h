// Functions behind scene_objects.h that a session calls directly.
#pragma once

#include "body_constraints.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

/// Does the same as the function in scene_objects.h, and stores the constraints for later edits.
/// `note` ← what is to tell about the equilibrium of initial.static, or nothing.
State make_initial_state(const Scene& scene, MechanicalSystem& system, BodyConstraints& constraints,
                         std::string& note);

/// Sets the scene's constraints in the system for an equilibrium, at which the body is not yet, and
/// stores them. Throws InputError if they contradict each other.
void set_constraints_of_equilibrium(const Scene& scene, MechanicalSystem& system,
                                    BodyConstraints& constraints);

/// Sets these constraints in the system and moves `position` so that it satisfies them. Returns the
/// constraints that the system had before. If the new ones contradict each other or an element
/// would be inverted, InputError is thrown, and system and position stay as they were. `advice` is the
/// end of the message about an inverted element: it says what to do.
Constraints constrain(MechanicalSystem& system, const BodyConstraints& constraints, double time,
                      Vector& position, const char* advice);

/// Throws InputError if the potential of a force term is not defined at `position`. The message
/// begins with `what`.
void require_defined_terms(const MechanicalSystem& system, const Vector& position, double time,
                           const std::string& what);

/// The vertices of a shift, in its order. Throws InputError for numbers that do not exist or occur
/// twice, for lists of different lengths, and for values that are not finite.
std::vector<Index> check_shift(const ShiftSettings& shift, const TetMesh& mesh);

}  // namespace tetraction
