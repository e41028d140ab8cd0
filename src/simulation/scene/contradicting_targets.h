// Events that constrain a vertex in two ways at once.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Follows the targets that the scene's [[fix]] and those of its events give in numbers, and their
/// velocities. Throws InputError, which names both, if a vertex has two different ones at the same time, or if one of
/// a free rigid handle has another constraint. Targets that depend on where the vertices are then are known only
/// in the run, and are left to it.
void refuse_contradicting_targets(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
