// "Did you mean …?" for names in a scene.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tetraction {

/// Names that can stand in one place of a scene.
using NameList = std::vector<std::string_view>;

/// "a, b or c".
std::string listing(const NameList& names);

/// The valid name that `word` most likely stands for, or an empty text when none is near: near is
/// an edit distance (with transpositions) of at most a third of the longer name, or one name
/// beginning with the other. Case does not count.
std::string_view nearest_name(std::string_view word, const NameList& valid);

/// "did you mean X?", or "valid are a, b or c" when nothing is near.
std::string advice(std::string_view word, const NameList& valid);

}  // namespace tetraction
