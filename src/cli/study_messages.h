// What `tetraction study` tells of its plan.
#pragma once

#include <string>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// What the reference is, and how many steps it takes.
std::string reference_message(const StudyPlan& plan);

/// What becomes of the wall times of runs that are made at the same time. Empty if they count.
std::string jobs_message(int jobs);

/// Says which of the runs of the plan were complete and have lost their folders since.
void tell_of_lost_runs(const std::string& directory, const StudyPlan& plan);

/// The name of a run in messages.
std::string run_text(const StudyPlan& plan, const PlannedRun& run);

/// The runs of a plan with the times that they take, of which the first steps tell.
std::string text_of_plan(const StudyPlan& plan, const TetMesh& mesh, const StudyMemory& memory);

}  // namespace tetraction
