// What a user should know of a scene or a result that is not wrong but may mislead.
#pragma once

#include <string>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A warning for nearly incompressible materials (Poisson's ratio at small strain from 0.45 on), whose
/// linear tetrahedra lock; empty without any.
std::string locking_warning(const MechanicalSystem& system);

/// The highest frequency that a step resolves, Hz. For the variational rules that is 1/(20 h), twenty
/// steps a period; for backward Euler 1/(400 h), where a vibration loses a tenth of its energy in a period.
double resolved_frequency(Integrator integrator, double time_step);

}  // namespace tetraction
