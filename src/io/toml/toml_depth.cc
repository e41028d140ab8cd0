#include "toml_depth.h"

#include <vector>

namespace tetraction {
namespace {

// The end of the string that begins at `begin`: the place after its closing quotes, or the place at
// which a parser would report an error.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  const char quote = text[begin];
  const bool has_escapes = quote == '"';
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const bool has_lines = text.substr(begin, 3) == three;
  std::size_t i = begin + (has_lines ? 3 : 1);
  while (i < text.size()) {
    if (text[i] == '\\' && has_escapes) {
      i += 2;
      continue;
    }
    if (!has_lines && (text[i] == quote || text[i] == '\n')) return i + 1;
    if (has_lines && text.substr(i, 3) == three) {
      i += 3;
      // Up to two quotes may stand before the three that close.
      for (int more = 0; more < 2 && i < text.size() && text[i] == quote; ++more) ++i;
      return i;
    }
    ++i;
  }
  return text.size();
}

TextPlace place_of(std::string_view text, std::size_t position) {
  TextPlace place;
  for (const char c : text.substr(0, position)) {
    ++place.column;
    if (c == '\n') place = {place.line + 1, 1};
  }
  return place;
}

}  // namespace

std::optional<TextPlace> place_of_deep_nesting(std::string_view text) {
  std::vector<std::size_t> outer;  // of each open bracket: the dots of the key before it
  std::size_t outer_depth = 0;     // all of these, and the brackets themselves
  std::size_t dots = 0;            // of the present key, within the innermost bracket
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = end_of_string(text, i);
      continue;
    }
    if (c == '#') {
      i = text.find('\n', i);
      if (i == std::string_view::npos) break;
      continue;
    }
    if (c == '.') {
      ++dots;
    } else if (c == '[' || c == '{') {
      outer.push_back(dots);
      outer_depth += dots + 1;
      dots = 0;
    } else if ((c == ']' || c == '}') && !outer.empty()) {
      dots = outer.back();
      outer_depth -= dots + 1;
      outer.pop_back();
    } else if (c == ',' || (c == '\n' && outer.empty())) {
      dots = 0;
    }
    if (outer_depth + dots > kDeepestNesting) return place_of(text, i);
    ++i;
  }
  return std::nullopt;
}

}  // namespace tetraction
