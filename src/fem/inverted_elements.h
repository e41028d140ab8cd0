// Finds inverted elements, those with J = det F < 0.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

class ElasticPotential;

/// Counts the elements with J < 0. One pass over the elements reads nothing but their edges e,
/// because det F has the sign of det e.
///
/// Keeps a reference to the potential. Make a new counter after a material was replaced.
class InversionCounter {
 public:
  explicit InversionCounter(const ElasticPotential& elastic);

  /// The number of elements with J < 0 at positions q (3 per vertex).
  Index count(const Vector& q);
  /// The same number, found faster, after a small step from a state without inverted elements to q.
  /// The last evaluation of the elastic energy must have been at q, with the result `energy`.
  /// Blocks are skipped if their energy is too small for an element to be near J = 0. The others
  /// are examined, but only in every fourth step as long as J > ½ in all of their elements.
  Index count_after_step(const Vector& q, double energy);
  /// The inverted element with the smallest number, or −1.
  Index first(const Vector& q) const;

 private:
  Index count(const Vector& q, bool is_small_step);

  const ElasticPotential& elastic_;
  std::vector<double> least_energy_;  // per block: below it no element is examined, J
  std::vector<int> pause_;            // per block: steps until it is examined again
};

}  // namespace tetraction
