#include "tetraction/dynamics/external_forces.h"

#include <algorithm>
#include <cmath>

namespace tetraction {
namespace {

// The fraction, 0 to 1, of the step of size h from `start` on that lies before `time`.
double part_of_step(double time, double start, double h) {
  const double end = start + h;
  // start = k h has round-off. A time within round-off of an end of the step is taken to be at that
  // end.
  const double round_off =
      16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(start), std::abs(end));
  if (std::abs(time - start) <= round_off) return 0.0;
  if (std::abs(time - end) <= round_off) return 1.0;
  return std::clamp((time - start) / h, 0.0, 1.0);
}

}  // namespace

void ExternalForces::add_load(const Vector& /*mass*/, double time, double h, Vector& force) const {
  for (const ExternalForce& each : forces_) {
    const double share = part_of_step(each.until, time, h) - part_of_step(each.from, time, h);
    if (!(share > 0.0)) continue;
    for (const Index v : each.vertices) vertex_block(force, v) += share * each.vector;
  }
}

}  // namespace tetraction
