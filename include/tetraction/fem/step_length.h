// How far a displacement can go before an element is inverted.
#pragma once

#include <functional>

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// The largest t ≤ 1 such that on the whole way from q to q + t d no element that is not inverted at
/// q loses more than nine tenths of its volume; exact to a tenth of that loss. Only elements for which
/// `counts` is true are looked at (empty: all).
double admissible_step(const RestState& rest, const Vector& q, const Vector& d,
                       const std::function<bool(Index)>& counts = {});

}  // namespace tetraction
