// How far a displacement can go before an element is inverted.
#pragma once

#include <functional>

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// The largest t ≤ 1 such that no element loses more than nine tenths of its volume anywhere on the
/// way from q to q + t d. Elements that are inverted at q do not count. t is exact to a tenth of
/// that loss. Only elements for which `counts` returns true are examined; if it is empty, all are.
double admissible_step(const RestState& rest, const Vector& q, const Vector& d,
                       const std::function<bool(Index)>& counts = {});

}  // namespace tetraction
