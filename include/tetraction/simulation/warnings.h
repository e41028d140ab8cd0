// Warnings about scenes and results that are valid but may mislead.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A warning for nearly incompressible materials (Poisson's ratio at small strain of 0.45 and
/// more), with which linear tetrahedra lock. Empty if the body has none.
std::string locking_warning(const MechanicalSystem& system);

/// The highest frequency that a step resolves, Hz. For the variational rules it is 1/(20 h), that
/// is, twenty steps in a period. For backward Euler it is 1/(400 h), at which a vibration loses a
/// tenth of its energy in a period.
double resolved_frequency(Integrator integrator, double time_step);

}  // namespace tetraction
