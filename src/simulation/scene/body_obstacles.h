// The contact of a body with the obstacles of a scene.
#pragma once

#include <memory>
#include <string>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The contact with all [[obstacle]] of the scene; null if there are none. Throws InputError.
std::shared_ptr<const Contact> make_contact(const Scene& scene, const MechanicalSystem& system);

/// Moves masses of vertices that may touch an obstacle into the body (contact.mass). Throws InputError.
void move_contact_masses(const Scene& scene, MechanicalSystem& system);
/// Throws InputError if a vertex penetrates an obstacle at these positions. The message begins with `what` and has the
/// obstacle, the numbers of some vertices and the depth.
void refuse_penetration(const MechanicalSystem& system, const Vector& position, double time,
                        const std::string& what);

/// Throws InputError if an obstacle has friction, which an equilibrium cannot have.
void refuse_friction(const Scene& scene);

/// A warning where an obstacle is so small that faces of the body may sink into it between their vertices; empty
/// without one.
std::string small_obstacle_warning(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
