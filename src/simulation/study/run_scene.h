// The scene of a run of a study.
#pragma once

#include <string>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The scene of the run's variant with integrator, step, settings and solver of the run. The settings of a rule come
/// after those of the variant.
Scene scene_of(const StudyPlan& plan, const PlannedRun& run);

/// The name with letters that are safe in a folder and in the list of --frames.
std::string folder_name(const std::string& name);

/// The settings of a rule as a part of the name of a folder. Other settings have another one.
std::string folder_name(const StudyRule& rule);

}  // namespace tetraction
