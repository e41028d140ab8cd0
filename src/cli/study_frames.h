// Which runs of a study write frames, and which of them its closing lines name.
#pragma once

#include <string>
#include <vector>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The run that a user most likely wants to see: that of the scene's own integrator at the step
/// with the ratio to the scene's step nearest to 1. If the study leaves that integrator out, it is
/// a run of another one.
const PlannedRun& run_to_look_at(const StudyPlan& plan);

/// The directories of the runs that write frames. `wanted` is the value of --frames, a list: empty for
/// run_to_look_at() alone, "all", "none", or runs by the names of their directories, where the step
/// may be written in any way. The first run is the one to be named at the end of the study. Throws
/// InputError for a run that the study does not make.
std::vector<std::string> runs_with_frames(const std::vector<std::string>& wanted,
                                          const StudyPlan& plan);

}  // namespace tetraction
