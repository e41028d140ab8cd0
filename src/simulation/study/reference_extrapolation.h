// The reference of a study that is extrapolated from three runs.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// What may be wrong in the motion of a run besides the error of its step.
struct Inexactness {
  double residuals = 0.0;  ///< by residuals that the solver left, relative to the displacements
  double round_off = 0.0;  ///< by round-off, relative to the positions and to the displacements
};

/// That of a run. The impulses of the residuals that the solver left are summed up in the balance of
/// angular momentum.
Inexactness inexactness(const StudyRow& row);

struct ExtrapolatedReference {
  ReferenceExtrapolation result;
  /// The motion of the reference: that of the run with h/2, with positions and error probe extrapolated as far
  /// as that is valid.
  std::shared_ptr<const MotionTrack> motion;
};

/// Extrapolates runs of `integrator` with the steps 2h, h and h/2 that have reached the end, as
/// ReferenceExtrapolation says. `step` is h, `probe` the error probe, without a name if there is none. `inexact` is that of
/// the least exact of the runs.
ExtrapolatedReference extrapolate_reference(
    Integrator integrator, double step, const Inexactness& inexact, const ErrorMeasure& probe,
    const std::array<std::shared_ptr<const MotionTrack>, 3>& tracks);

}  // namespace tetraction
