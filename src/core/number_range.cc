#include "tetraction/core/number_range.h"

#include <fmt/format.h>

#include <cmath>

namespace tetraction {
namespace {

constexpr double kSmallest = 1e-30;
constexpr double kLargest = 1e30;

bool is_moderate(double value) {
  const double size = std::abs(value);
  return size == 0.0 || (size >= kSmallest && size <= kLargest);
}

bool within(const NumberRange& range, double value) {
  return (range.least_itself ? value >= range.least : value > range.least) &&
         (range.most_itself ? value <= range.most : value < range.most);
}

}  // namespace

bool NumberRange::contains(double value) const {
  return refusal(value).empty();
}

std::string NumberRange::text() const {
  const bool below = std::isfinite(least);
  const bool above = std::isfinite(most);
  std::string low = fmt::format(fmt::runtime(least_itself ? "{} or more" : "above {}"), least);
  std::string high = fmt::format(fmt::runtime(most_itself ? "{} or less" : "below {}"), most);
  if (below && above) {
    if (least_itself && most_itself) return fmt::format("from {} to {}", least, most);
    if (!least_itself && !most_itself) {
      return fmt::format("between {} and {}, both excluded", least, most);
    }
    return low + " and " + high;
  }
  if (below) return low;
  if (above) return high;
  return "any number";
}

std::string NumberRange::refusal(double value) const {
  if (std::isnan(value) || (std::isinf(value) && !infinity)) return "; it must be finite.";
  if (!within(*this, value)) {
    const bool between = std::isfinite(least) && std::isfinite(most);
    return fmt::format("; it must {} {}{}.", between ? "lie" : "be", text(), advice);
  }
  if (is_moderate && !tetraction::is_moderate(value)) {
    return "; its size must lie between 1e-30 and 1e30, or what is computed from it overflows. "
           "Choose other units if it is meant.";
  }
  return {};
}

}  // namespace tetraction
