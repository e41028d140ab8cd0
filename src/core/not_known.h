// The value of a number that is not known.
#pragma once

#include <limits>

namespace tetraction {

inline constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

}  // namespace tetraction
