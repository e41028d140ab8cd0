// The cause of a failed step, and its remedy.
#pragma once

#include <optional>
#include <string>

#include "simulation/stepping/run_data.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

/// The cause of a failure, of which the place is known.
FailureCause cause_of(const RunData& run, const StepOutcome& outcome, const StepFailure& failure);

/// The remedy for the user. `advice`: StepStrategy::advice().
std::string remedy_for(const RunData& run, const StepFailure& failure, const StepOutcome& outcome,
                       const std::string& advice);

/// Whether prescribed motion leads vertices at that time to where positions are not finite.
bool leads_out_of_range(const MechanicalSystem& system, const State& from, double time);

/// A term and a vertex whose force is not a finite number.
struct BadForce {
  std::string term;
  Index vertex = 0;
};

/// The first one, if there is one.
std::optional<BadForce> bad_force(const MechanicalSystem& system, const ForcePoint& at);

}  // namespace tetraction
