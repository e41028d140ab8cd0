// The settings of a run before and after the events of its scene.
#pragma once

#include <cstddef>

#include "tetraction/simulation/run_settings.h"

namespace tetraction {

/// The settings that a scene begins with, without those of constraints.
RunSettings initial_settings(const Scene& scene);

/// The settings after the first `event_count` events of the scene, which may be made by an earlier
/// part of a run. They are as Session has them, except that `constraints` and `obstacles` have the settings only: the
/// objects depend on where the vertices were when an event was made, and the starts on when it was. Throws InputError if an event
/// changes what does not exist.
RunSettings settings_after_events(const Scene& scene, std::size_t event_count);

/// Puts the settings into `settings.constraints`, whose objects have the numbers of a run (positions,
/// velocities, times): names, amplitudes, and lengths of distances that the scene does not give.
/// Throws InputError if the objects do not belong to these settings.
void complete_constraints(const Scene& scene, RunSettings& settings);

}  // namespace tetraction
