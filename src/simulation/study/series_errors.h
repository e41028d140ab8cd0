// Errors of a study from the values of runs over time.
#pragma once

#include <cstddef>

#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {

// The values of a trace have `width` numbers for each time; |s| is their magnitude. All errors are relative
// and NaN if a trace has no values or the scale is 0.

/// The largest |s|.
double peak(const ProbeTrace& trace, std::size_t width);

/// The frequency of the component that varies most, dominant_frequency(), Hz.
double main_frequency(const ProbeTrace& trace, std::size_t width, std::size_t component);

/// The component of a trace with the largest variance.
std::size_t liveliest_component(const ProbeTrace& trace, std::size_t width);

/// The error of a run:
/// - kProbe: the largest |s − s_ref| over the times of the run, over the largest |s_ref|. The values of the
///   reference are interpolated linearly;
/// - kPeak: |max|s| − max|s_ref||, over max|s_ref|;
/// - kFrequency: |f − f_ref|, over f_ref, of the component that varies most in the reference;
/// - kEnergy: as kProbe, of one column of history.csv.
double series_error(ErrorKind kind, const ProbeTrace& run, const ProbeTrace& reference,
                    std::size_t width);

}  // namespace tetraction
