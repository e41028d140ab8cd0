// The potential of a contact layer as a function of the squared distance D = d².
#pragma once

#include "tetraction/dynamics/contact/barrier.h"

namespace tetraction {

/// dU/dD at the distance d.
inline double slope_of_square(const Barrier& barrier, double d) {
  return barrier.slope(d) / (2.0 * d);
}
/// d²U/dD².
inline double curvature_of_square(const Barrier& barrier, double d) {
  return (barrier.curvature(d) - barrier.slope(d) / d) / (4.0 * d * d);
}
/// ΔU/ΔD between the distances `from` and `to`.
inline double mean_slope_of_square(const Barrier& barrier, double from, double to) {
  return barrier.mean_slope(from, to) / (from + to);
}
/// The derivative of mean_slope_of_square() by the square of `to`.
inline double mean_slope_rate_of_square(const Barrier& barrier, double from, double to) {
  const double sum = from + to;
  return (barrier.mean_slope_rate(from, to) - barrier.mean_slope(from, to) / sum) /
         (2.0 * to * sum);
}

}  // namespace tetraction
