// How deeply the keys, lists and tables of a TOML text are nested.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace tetraction {

/// The allowed depth, of which no scene needs a tenth. A tree is walked and destroyed by recursion;
/// without a limit a deep tree would end the program.
inline constexpr std::size_t kDeepestNesting = 64;

/// A place in a text, counted from 1.
struct TextPlace {
  std::size_t line = 1;
  std::size_t column = 1;
};

/// The first place where the text is nested more deeply than kDeepestNesting, or nothing. Each dot
/// of a key and each open bracket counts. To be called before the text is parsed. Errors in the
/// TOML are left to the parser.
std::optional<TextPlace> place_of_deep_nesting(std::string_view text);

}  // namespace tetraction
