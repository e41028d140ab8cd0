// Errors of a study from the values of runs over time.
#pragma once

#include "tetraction/simulation/motion_track.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {

/// The relative error of the values of a run. |s| is the magnitude of the values at a time as a vector. NaN if a
/// record has no values or the divisor is 0.
/// - kProbe: the largest |s − s_ref| over the times of the run, over the largest |s_ref|. The values of
///   the reference are interpolated linearly;
/// - kPeak: |max|s| − max|s_ref||, over max|s_ref|;
/// - kFrequency: |f − f_ref|, over f_ref, with dominant_frequency() of the component that varies most in the
///   reference.
double series_error(ErrorKind kind, const ProbeRecord& run, const ProbeRecord& reference);

}  // namespace tetraction
