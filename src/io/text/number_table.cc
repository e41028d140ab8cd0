#include "number_table.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>

#include "tetraction/core/error.h"
#include "text_scanner.h"

namespace tetraction {
namespace {

constexpr std::string_view kBlank = " \t\r";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// The entries of a line. An empty entry between two separators stays as an empty text.
std::vector<std::string_view> entries_of(std::string_view line) {
  std::vector<std::string_view> entries;
  const bool is_separated = line.find_first_of(",;") != std::string_view::npos;
  const std::string_view separators = is_separated ? ",;" : " \t";
  while (true) {
    const auto end = line.find_first_of(separators);
    entries.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return entries;
    line.remove_prefix(end + 1);
    if (!is_separated) line = trimmed(line);
  }
}

bool read_number(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

}  // namespace

std::vector<std::vector<double>> read_number_table(const std::string& path, std::size_t columns) {
  const std::string text = read_file(path);
  std::string_view rest = text;
  // A byte-order mark, which some programs write.
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  std::vector<std::vector<double>> rows;
  bool is_first = true;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const auto end = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string_view> entries = entries_of(line);
    double value = 0.0;
    if (is_first && !read_number(entries.front(), value) &&
        std::string_view("0123456789+-.").find(entries.front().substr(0, 1)) ==
            std::string_view::npos) {
      is_first = false;
      continue;
    }
    is_first = false;
    if (entries.size() != columns) {
      throw FileError(fmt::format("{}:{}: a line needs {} numbers, and this one has {}.", path,
                                  number, columns, entries.size()));
    }
    std::vector<double>& row = rows.emplace_back();
    for (const std::string_view entry : entries) {
      if (!read_number(entry, value)) {
        throw FileError(fmt::format("{}:{}: \"{}\" is not a finite number.", path, number,
                                    entry.substr(0, 40)));
      }
      row.push_back(value);
    }
  }
  if (rows.empty()) throw FileError(path + ": the file has no row of numbers.");
  return rows;
}

}  // namespace tetraction
