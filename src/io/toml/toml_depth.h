// How deeply the keys, lists and tables of a TOML text are nested.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace tetraction {

/// No scene needs a tenth of it. A tree is walked and destroyed by recursion, so that one without a
/// bound ends the program.
inline constexpr std::size_t kDeepestNesting = 64;

/// A place in a text, counted from 1.
struct TextPlace {
  std::size_t line = 1;
  std::size_t column = 1;
};

/// Where the text is nested more than kDeepestNesting deep for the first time; nothing if it never
/// is. Each dot of a key and each open bracket counts. To be asked before the text is parsed: what
/// is not valid TOML is left to the parser.
std::optional<TextPlace> place_of_deep_nesting(std::string_view text);

}  // namespace tetraction
