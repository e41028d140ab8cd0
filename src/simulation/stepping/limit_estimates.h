// The stability limit during a run.
#pragma once

#include "run_data.h"

namespace tetraction {

/// The stability limit of the present rule at positions q. `modes`: see stability_limit().
StabilityLimit limit_at(const RunData& run, const Vector& q, CriticalModes* modes = nullptr);
/// The same, and enters the time it takes.
StabilityLimit timed_limit(RunData& run, const Vector& q, CriticalModes* modes = nullptr);
/// The smaller one of the stability limits at the start and now, s.
double present_limit(const RunData& run);
/// The limit that time.step = "auto" follows, s: that of stability, or twice the step that resolves the
/// damping of single vertices if it is smaller.
double automatic_limit(const RunData& run, const StabilityLimit& limit);
/// The limit that obstacles leave of a limit of the body alone, s, while the run goes on in steps of the length
/// `step`, s. Obstacles that nothing can reach soon are not looked at (Contact::impact_forecast()).
double limit_beside_obstacles(RunData& run, double critical_step, double step);
/// Begins to follow the limit, which was computed at the present state.
void start_to_follow(RunData& run, double critical_step, CriticalModes modes);
/// Estimates the limit at the present state from the last modes. Enters it, and returns the step that follows
/// from it for time.step = "auto", s.
double enter_estimate(RunData& run);

}  // namespace tetraction
