// What `tetraction study` tells of its plan.
#pragma once

#include <string>
#include <vector>

#include "io/study/study_maker.h"

namespace tetraction {

/// What the reference is, and how many steps it takes.
std::string reference_message(const StudyPlan& plan);

/// What becomes of the wall times of runs that are made at the same time. Empty if they count.
std::string jobs_message(int jobs);

/// Says which of the runs of the plan were complete and have lost their folders since.
void tell_of_lost_runs(const std::string& directory, const StudyPlan& plan);

/// The name of a run in messages.
std::string run_text(const StudyPlan& plan, const PlannedRun& run);

/// A table of runs of a plan with the times that they take, with their sum in the last line.
std::string text_of_plan(const StudyPlan& plan, const std::vector<PlannedTime>& runs);

}  // namespace tetraction
