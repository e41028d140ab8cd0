// Which elements are turned inside out: J = det F < 0.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

class ElasticPotential;

/// Counts the elements with J < 0. One pass over the elements that reads nothing but their edges: det F
/// has the sign of det e.
///
/// Keeps a reference; make a new one when a material was exchanged.
class InversionCounter {
 public:
  explicit InversionCounter(const ElasticPotential& elastic);

  /// The number of elements with J < 0 at positions q (3 per vertex).
  Index count(const Vector& q);
  /// The same after a small step from a state without any to q, where the elastic energy was evaluated
  /// last, with the result `energy`. Passes over blocks that have too little energy for one of their
  /// elements to have come near J = 0, and looks at the others at every fourth step as long as J > ½ in
  /// all of their elements.
  Index count_after_step(const Vector& q, double energy);
  /// The first of them by number, or −1.
  Index first(const Vector& q) const;

 private:
  Index count(const Vector& q, bool is_small_step);

  const ElasticPotential& elastic_;
  std::vector<double> least_energy_;  // per block, that makes it worth looking, J
  std::vector<int> pause_;            // per block, steps before it is looked at again
};

}  // namespace tetraction
