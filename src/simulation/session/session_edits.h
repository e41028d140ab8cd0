// Edits between two steps.
#pragma once

#include <memory>
#include <string>

#include "simulation/stepping/run_data.h"
#include "simulation/stepping/step_strategy.h"

namespace tetraction {

/// Makes an edit at the present state of a run: changes settings, body, state and plan, and adds an entry
/// to the edits of its progress. `strategy` is replaced if its settings have changed. If the edit cannot be
/// made, an exception is thrown and all is as before. `at`: the requested time, s; `what`: kept in the entry.
void apply_edit(RunData& run, std::unique_ptr<StepStrategy>& strategy, const Edit& edit, double at,
                const std::string& what);

}  // namespace tetraction
