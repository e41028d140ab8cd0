// The reference of a study that is extrapolated from three runs.
#pragma once

#include <array>
#include <vector>

#include "position_errors.h"
#include "probe_errors.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// What was recorded of a run that a reference is made from.
struct ReferenceRecord {
  ReferenceRecord(const std::vector<double>& times, const std::string& error_probe)
      : track(times), probe(error_probe) {}

  ReferenceTrack track;
  ReferenceProbe probe;
};

/// Differences of a run from the reference that it takes part in.
struct ReferenceDistance {
  double at_end = 0.0;     ///< |q − q_ref| at the end, m
  double over_time = 0.0;  ///< root mean square of |q − q_ref| at the times of its own steps, m
  double of_probe = 0.0;   ///< the largest difference of the error probe, its unit
};

/// The differences of a run from a reference. Both have reached the end.
ReferenceDistance distance_between(const ReferenceRecord& run, const ReferenceRecord& reference);

/// What may be wrong in the motion of a run besides the error of its step.
struct Inexactness {
  double residuals = 0.0;  ///< by residuals that the solver left, relative to the displacements
  double round_off = 0.0;  ///< by round-off, relative to the positions and to the displacements
};

struct ExtrapolatedReference {
  ReferenceExtrapolation result;
  std::array<ReferenceDistance, 3> distances;  ///< of the runs with 2h, h and h/2
};

/// Extrapolates runs of `integrator` with the steps 2h, h and h/2 that have reached the end, as
/// ReferenceExtrapolation says. If the extrapolation is valid, records[2] becomes that of the
/// extrapolation. `step` is h. `inexact` is that of the least exact of the runs.
ExtrapolatedReference extrapolate_reference(Integrator integrator, double step,
                                            const Inexactness& inexact,
                                            std::array<ReferenceRecord*, 3> records);

}  // namespace tetraction
