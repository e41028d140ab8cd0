// Finds inverted elements, those with J = det F < 0.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

class ElasticPotential;
class RestState;

/// The quadratic elements with J < 0 at one of their nodes. J is positive there at rest, and materials
/// look at J only at the points of quadrature, so that a corner may turn inside out without resistance.
struct InvertedAtNodes {
  Index count = 0;
  Index first = -1;  ///< the one with the smallest number
};
InvertedAtNodes inverted_at_nodes(const RestState& rest, const Vector& q);

/// Counts the elements with J < 0. This needs only the current edges e of the elements, because
/// det F has the sign of det e.
///
/// Keeps a reference to the potential, which must live longer. Make a new counter after a material
/// was replaced.
class InversionCounter {
 public:
  explicit InversionCounter(const ElasticPotential& elastic);

  /// The number of elements with J < 0 at positions q (3 per vertex).
  Index count(const Vector& q);
  /// Counts faster than count(), after a step from positions `before` without inverted elements to q. The
  /// last evaluation of the elastic energy must have been at q, with the result `energy`.
  ///
  /// A block is skipped if its energy is too small for any element to be near J = 0. A block in which
  /// J > ½ in all elements is skipped in the next three steps. No block is skipped after a step in which
  /// some F may have changed by more than 0.1, because such a step can lead from J > 0 to a mirrored
  /// element with little energy.
  Index count_after_step(const Vector& before, const Vector& q, double energy);
  /// The inverted element with the smallest number, or −1.
  Index first(const Vector& q) const;

 private:
  Index count(const Vector& q, bool is_small_step);
  bool is_small(const Vector& before, const Vector& q) const;

  const ElasticPotential& elastic_;
  std::vector<double> energy_threshold_;  // per block: with less energy it is skipped, J
  std::vector<int> steps_to_skip_;        // per block: steps until it is examined again
  double small_motion_ = 0.0;             // m: relative motions of vertices in a small step
};

}  // namespace tetraction
