// The scene of a run of a study.
#pragma once

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The scene of the run's variant with integrator, step and solver of the run.
Scene scene_of(const StudyPlan& plan, const PlannedRun& run);

}  // namespace tetraction
