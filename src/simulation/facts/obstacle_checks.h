// Checks of a scene with obstacles, and warnings about them.
#pragma once

#include <string>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Throws InputError if a vertex penetrates an obstacle or another body at these positions. The message begins with
/// `what` and has the obstacle, the numbers of some vertices and the depth.
void refuse_penetration(const MechanicalSystem& system, const Vector& position, double time,
                        const std::string& what);

/// Throws InputError if an obstacle has friction, which an equilibrium cannot have.
void refuse_friction(const Scene& scene);

/// Warnings where an obstacle is so small that faces of the body may sink into it between their vertices, and where a
/// layer is far stiffer or softer than the body.
std::vector<std::string> obstacle_warnings(const Scene& scene, const MechanicalSystem& system);

/// Throws InputError where an event gives an obstacle the name of another one, or removes one that was removed already,
/// and for a probe of an obstacle that neither the scene nor an event has.
void check_obstacle_names(const Scene& scene);

}  // namespace tetraction
