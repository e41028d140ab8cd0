// Why a step failed, where in the body, and what the user can do.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// The causes that are told apart, because each has a remedy of its own.
enum class FailureCause {
  kStepAboveLimit,     ///< an explicit rule with a step above its stability limit
  kStepTooLarge,       ///< the step does not resolve the motion
  kLoads,              ///< loads or an environment out of all proportion to the body
  kSpeed,              ///< vertices that are much faster than waves in the material
  kStiffnessContrast,  ///< parts whose moduli differ by more than the solver can bridge
  kPrescribedMotion,   ///< supports that crush the elements beside them
  kConstraints,        ///< distances or handles that cannot be met
  kDamping,            ///< damping that would reverse velocities
  kTolerance,          ///< a tolerance below round-off
  kIterations,         ///< the iterations allowed were used up while the residual still fell
  kForceTerm,          ///< a force term that is not defined or not finite where a vertex came
  kSolver              ///< the equations of the step are not solved, for none of these reasons
};

template <>
struct EnumNames<FailureCause> {
  static constexpr std::array names{
      "step_above_limit",   "step_too_large",    "loads",       "speed",
      "stiffness_contrast", "prescribed_motion", "constraints", "damping",
      "tolerance",          "iterations",        "force_term",  "solver"};
};

/// A step that failed. The state of the session is the one before the step, but with a blow-up of the
/// energy, which is found after the step.
struct StepFailure {
  Index step = 0;          ///< number of the step that failed
  double time = 0.0;       ///< where it began, s
  double time_step = 0.0;  ///< its length, s
  /// The stability limit of the explicit rules at the last good state, s. 0 if it is not known.
  double stable_step = 0.0;
  FailureCause cause = FailureCause::kSolver;
  std::string what;    ///< what went wrong, one clause
  std::string remedy;  ///< what the user can do, whole sentences
  /// The elements concerned (internal numbers), the worst first: those with J ≤ 0 or numbers that are
  /// not finite where the step led them, or else those with the largest elastic energy densities.
  std::vector<Index> elements;
  Index element_count = 0;  ///< the number of them, of a body in parts in all processes
  int process = 0;          ///< of a body in parts: the one that has the worst of them
  /// J of the first element, where the step led it if this is known, or else at the last good state.
  double jacobian = std::numeric_limits<double>::quiet_NaN();
  /// Where the step led the vertices (3 per vertex, m). Empty if it is not known.
  Vector attempted_position;
};

}  // namespace tetraction
