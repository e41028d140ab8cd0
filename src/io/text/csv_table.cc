#include "csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/quoting.h"
#include "file_kind.h"
#include "tetraction/core/error.h"
#include "text_scanner.h"

namespace tetraction {
namespace {

std::string_view trimmed_cell(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

// An empty entry between two commas stays as an empty text, which is no number.
std::vector<std::string_view> entries_of(std::string_view line) {
  std::vector<std::string_view> entries;
  const bool has_commas = line.find_first_of(",;") != std::string_view::npos;
  for (;;) {
    const auto end = line.find_first_of(has_commas ? ",;" : " \t");
    entries.push_back(trimmed_cell(line.substr(0, end)));
    if (end == std::string_view::npos) return entries;
    line.remove_prefix(end + 1);
    if (!has_commas) line = trimmed_cell(line);
  }
}

bool parse(std::string_view text, double& value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

// Also one that no double holds.
bool looks_like_number(std::string_view text) {
  double value = 0.0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error != std::errc::invalid_argument && end == text.data() + text.size();
}

}  // namespace

CsvTable read_csv(const std::string& path) {
  constexpr std::size_t kLargestTable = std::size_t{1} << 28U;
  const std::string file = read_file(path, kLargestTable);
  refuse_other_kinds(path, file, "a table of numbers");
  std::string_view text = file;
  CsvTable table;
  std::size_t columns = 0;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto end = text.find('\n');
    const std::string_view content = trimmed_cell(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (content.empty() || content.front() == '#') continue;
    const std::vector<std::string_view> entries = entries_of(content);
    const auto fail = [&](const std::string& what) {
      throw FileError(fmt::format("{}:{}: {}", path, line, what));
    };
    double value = 0.0;
    if (columns == 0) {
      columns = entries.size();
      // A line with a number in it is a line of numbers, of which one is wrong.
      if (std::ranges::none_of(entries, looks_like_number)) {
        table.header.assign(entries.begin(), entries.end());
        continue;
      }
    }
    if (content.find(';') != std::string_view::npos &&
        content.find(',') != std::string_view::npos) {
      fail(
          "the line has semicolons and commas. If the commas are decimal commas, write decimal "
          "points; otherwise separate the numbers in one way.");
    }
    if (entries.size() != columns) {
      fail(fmt::format("the line has {} columns, the first one has {}.", entries.size(), columns));
    }
    CsvTable::Row row{line, {}};
    for (const std::string_view entry : entries) {
      if (!parse(entry, value) || !std::isfinite(value)) {
        fail(
            fmt::format("{} is not a finite number. Numbers have a decimal point, and commas, "
                        "semicolons or spaces between them.",
                        in_quotes(entry)));
      }
      row.values.push_back(value);
    }
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) throw FileError(path + ": the file has no line of numbers.");
  return table;
}

}  // namespace tetraction
