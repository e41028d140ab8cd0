// The largest speed of what the mouse drags.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// The largest speed as a fraction of the wave speed. What is faster than the waves in the body inverts elements.
inline constexpr double kWaveSpeedFraction = 0.25;

/// The slowest speed of shear waves in the body, m/s.
inline double slowest_shear_wave(const Session& session) {
  double slowest = std::numeric_limits<double>::infinity();
  const MechanicalSystem& system = session.system();
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    slowest = std::min(slowest, std::sqrt(system.lame(e).mu / system.density(e)));
  }
  return slowest;
}

}  // namespace tetraction::viewer
