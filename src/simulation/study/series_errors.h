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
///   reference;
/// - kEnergy: the largest |E − E_ref| as for kProbe, over the largest |E_ref − E_ref(0)|, which do not
///   depend on where a potential energy is zero. If the reference is constant, over the largest |E_ref|.
double series_error(ErrorKind kind, const ProbeRecord& run, const ProbeRecord& reference);

/// The same of the values that the measure names in two tracks; NaN if one of them has none. The divisor of
/// `total_energy`, which hardly changes in a body without losses, is at least those of its kinetic, elastic and
/// environment energies.
double series_error(const ErrorMeasure& measure, const MotionTrack& run,
                    const MotionTrack& reference);

/// What such an error is the error of: max|s| of a run for kPeak, f for kFrequency. NaN for other kinds.
double series_value(const ErrorMeasure& measure, const MotionTrack& run,
                    const MotionTrack& reference);

/// The divisor of that error for kProbe, kPeak and kEnergy. 0 without values.
double series_scale(const ErrorMeasure& measure, const MotionTrack& reference);

}  // namespace tetraction
