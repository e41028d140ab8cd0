// Which elements are turned inside out: J = det F < 0.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

class ElasticPotential;

/// The number of elements with J < 0 at positions q (3 per vertex). One pass over the elements that
/// reads nothing but the edges: det F has the sign of det e.
Index count_inverted(const ElasticPotential& elastic, const Vector& q);

/// The first of them by number, or −1.
Index first_inverted(const ElasticPotential& elastic, const Vector& q);

}  // namespace tetraction
