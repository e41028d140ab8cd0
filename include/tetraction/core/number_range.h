// The range of numbers that a parameter may have, and its text in messages.
#pragma once

#include <limits>
#include <string>

namespace tetraction {

/// An interval of real numbers. It never contains NaN, and it contains infinity only if `infinity`
/// is true.
struct NumberRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool least_itself = true;  ///< whether `least` belongs to the range
  bool most_itself = true;   ///< whether `most` belongs to the range
  bool infinity = false;     ///< whether infinity is allowed
  /// Whether numbers other than 0 must have a magnitude between 1e-30 and 1e30. Moduli and similar
  /// numbers need this, because their products and single-precision copies would overflow
  /// otherwise.
  bool is_moderate = false;
  const char* advice = "";  ///< text that refusal() adds after the range, with its punctuation

  bool contains(double value) const;
  /// "above 0", "0 or more", "between 0 and 1, both excluded", "from 0 to 0.49", "any number".
  std::string text() const;
  /// The end of a message about a number that is not allowed, such as "; it must be above 0." Empty
  /// if the number is allowed.
  std::string refusal(double value) const;
};

inline constexpr NumberRange kFinite{};
inline constexpr NumberRange kPositive{.least = 0.0, .least_itself = false};
inline constexpr NumberRange kNotNegative{.least = 0.0};
inline constexpr NumberRange kModerate{.is_moderate = true};
inline constexpr NumberRange kModeratePositive{
    .least = 0.0, .least_itself = false, .is_moderate = true};
inline constexpr NumberRange kModerateNotNegative{.least = 0.0, .is_moderate = true};

}  // namespace tetraction
