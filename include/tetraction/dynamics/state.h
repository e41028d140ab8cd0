// The state that a time step carries forward.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// Node k of a trajectory. All fields are DOF-ordered (3 per vertex). The assignment of a state of the
/// same body copies its numbers, so that the vectors keep their addresses.
struct State {
  Index step = 0;
  double time = 0.0;  ///< s
  Vector position;    ///< q, m
  Vector momentum;    ///< p, the Hamilton–Pontryagin momentum, kg m/s
  Vector velocity;    ///< v of the step just taken, m/s (M⁻¹p before the first)
};

}  // namespace tetraction
