// The warnings of a run for its user.
#pragma once

#include <string>
#include <vector>

#include "simulation/scene/body_constraints.h"
#include "simulation/stepping/step_strategy.h"

namespace tetraction {

/// A warning about a step above the limit, or an empty text.
std::string step_warning(const RunData& run, const StabilityLimit& limit);
/// A warning about distances that are given more than once, or an empty text.
std::string repeated_constraint_warning(const std::vector<SharedDistance>& shared);
/// A warning about quadratic elements that are inverted at a node, or an empty text.
std::string inverted_corner_warning(const MechanicalSystem& system, const Vector& position);

/// Adds warnings about nearly incompressible, thin and unstable bodies.
void warn_of_materials(RunData& run);
/// Adds a warning about a slow BLAS if the steps are implicit at the start or after an event.
void warn_of_blas(RunData& run);
/// Adds warnings about events that are too early or too late.
void warn_of_events(RunData& run);
/// Adds warnings about loads that never act.
void warn_of_loads(RunData& run);
/// Adds warnings about settings of adaptive steps without such steps.
void warn_of_unused_settings(RunData& run);
/// Adds warnings about steps that were repeated or missed what adapts them, about events for which no step
/// was left, round-off, and a large energy error.
void warn_at_the_end(RunData& run, const StepStrategy& strategy);

}  // namespace tetraction
