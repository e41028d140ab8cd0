// The elements of a body in which a step failed.
#pragma once

#include <string>

#include "simulation/stepping/run_data.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

/// Finds the elements of a failure and enters them. `element`: one that is known, or −1.
void locate(const RunData& run, Index element, StepFailure& failure);

/// The worst element in words, as " at element 5 (region 0, …)". Empty without one.
std::string place_of(const MechanicalSystem& system, const StepFailure& failure);

/// Whether the worst element is at a vertex that is held or led.
bool worst_is_held(const MechanicalSystem& system, const StepFailure& failure);

}  // namespace tetraction
