#include "spelling.h"

#include <fmt/format.h>

#include <algorithm>

#include "quoting.h"

namespace tetraction {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    // "youngs-modulus" and "youngs_modulus" are the same word to a user.
    if (c == '-') c = '_';
  }
  return lower;
}

// Optimal string alignment: insertions, deletions, replacements, swaps of neighbours.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string listing(const NameList& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    constexpr std::size_t kMost = 60;
    if (i == kMost) return text + fmt::format(" or {} more", names.size() - i);
    if (i > 0) text += i + 1 < names.size() ? ", " : " or ";
    text += excerpt(names[i]);
  }
  return text;
}

std::string_view nearest_name(std::string_view word, const NameList& valid) {
  constexpr std::size_t kLongestWord = 64;  // the cost of the distance is quadratic
  if (word.size() > kLongestWord) return {};
  const std::string typed = lower_case(word);
  std::string_view best;
  std::size_t best_distance = kLongestWord;
  for (const std::string_view name : valid) {
    const std::string candidate = lower_case(name);
    const std::size_t distance = edit_distance(typed, candidate);
    const std::size_t shorter = std::min(typed.size(), candidate.size());
    const bool near = 3 * distance <= std::max(typed.size(), candidate.size()) ||
                      (shorter >= 3 && typed.compare(0, shorter, candidate, 0, shorter) == 0);
    if (near && distance < best_distance) {
      best = name;
      best_distance = distance;
    }
  }
  return best;
}

std::string advice(std::string_view word, const NameList& valid) {
  const std::string_view near = nearest_name(word, valid);
  if (!near.empty()) return fmt::format("did you mean {}?", near);
  return fmt::format("valid {} {}.", valid.size() == 1 ? "is only" : "are", listing(valid));
}

}  // namespace tetraction
