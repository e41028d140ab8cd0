#include "gmsh_data.h"

#include <fmt/format.h>

#include <array>
#include <unordered_set>

#include "core/quoting.h"

namespace tetraction {

std::string quoted_text(const TextScanner& in, std::string_view line, const char* missing) {
  const auto open = line.find('"');
  const auto close = line.rfind('"');
  if (open == std::string_view::npos || close == open) in.fail(missing);
  return std::string(line.substr(open + 1, close - open - 1));
}

// Texts of which the first is the array's name; real numbers; whole numbers, of which the second is
// the number of components and the third the number of rows; then the rows. All but the rows is text in
// both variants.
GmshData read_gmsh_data(TextScanner& in, GmshNumbers& numbers, const char* item) {
  GmshData data;
  const std::int64_t texts = in.count("the number of texts", 2);
  for (std::int64_t i = 0; i < texts; ++i) {
    if (!in.next_is('"')) in.fail("a text is not in quotes.");
    std::string text = quoted_text(in, in.line(), "a text does not end.");
    if (i == 0) data.name = std::move(text);
  }
  const std::int64_t reals = in.count("the number of real numbers", 2);
  for (std::int64_t i = 0; i < reals; ++i) in.real("a real number");
  const std::int64_t integers = in.count("the number of whole numbers", 2);
  if (integers < 3) in.fail(fmt::format("the numbers of components and {}s are missing.", item));
  std::array<std::int64_t, 3> sizes{};
  for (std::int64_t i = 0; i < integers; ++i) {
    const std::int64_t value = in.integer("a whole number");
    if (i < 3) sizes[static_cast<std::size_t>(i)] = value;
  }
  const std::int64_t components = sizes[1];
  if (components != 1 && components != 3 && components != 9) {
    in.fail(fmt::format("an array has {} components, but 1, 3 and 9 are possible.", components));
  }
  numbers.begin_section();
  const std::int64_t rows = in.checked_count(
      sizes[2], "the number of rows", numbers.binary() ? 4 + 8 * components : 2 * components + 2);
  data.values.resize(components, rows);
  std::unordered_set<std::int64_t> known;
  for (std::int64_t r = 0; r < rows; ++r) {
    data.tags.push_back(numbers.binary() ? numbers.int32("the number of a row")
                                         : in.integer("the number of a row"));
    if (!known.insert(data.tags.back()).second) {
      in.fail(
          fmt::format("the array {} has {} {} twice, and which of its values holds is ambiguous.",
                      in_quotes(data.name), item, data.tags.back()));
    }
    for (std::int64_t k = 0; k < components; ++k) data.values(k, r) = numbers.real("a value");
  }
  return data;
}

}  // namespace tetraction
