// The largest number of steps of a run.
#pragma once

namespace tetraction {

/// Double precision represents all integers up to this one, so that steps can be counted.
constexpr double kMostSteps = 9e15;

}  // namespace tetraction
