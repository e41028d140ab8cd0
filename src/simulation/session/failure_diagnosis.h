// A failed step explained to the user: what went wrong, where, why, and the remedy that fits the cause.
#pragma once

#include <string>

#include "simulation/stepping/run_data.h"
#include "simulation/stepping/step_strategy.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

struct Diagnosis {
  StepFailure failure;
  RunStatus status = RunStatus::kUnstable;  ///< how the run has ended
  bool has_place = false;                   ///< whether the message names the worst element
};

/// A step that could not be made. `tried`: the state to which the stepper wrote, if it got so far.
Diagnosis diagnose_step(const RunData& run, const StepStrategy& strategy,
                        const StepOutcome& outcome, const State& tried);
/// A run that cannot go on.
Diagnosis diagnose_collapse(const RunData& run, const StepStrategy& strategy,
                            const StepCollapse& collapse);
/// An energy that has blown up in the last step.
Diagnosis diagnose_blow_up(const RunData& run, const StepStrategy& strategy);

/// Sets status and message of a run that ends so.
void end_run(RunData& run, const Diagnosis& diagnosis);

/// A note if a vertex is or was so near a singular centre that its energy there is meaningless. It is kept
/// in the progress of the run.
std::string center_note(RunData& run);

}  // namespace tetraction
