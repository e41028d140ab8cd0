#include "report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction::benchmarks {
namespace {

// Formats a number with this many significant digits, without an exponent if its size is readable.
std::string number_text(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size != 0.0 && (size < 1e-3 || size >= 1e7)) return fmt::format("{:.{}g}", value, digits);
  const int leading = size == 0.0 ? 0 : static_cast<int>(std::floor(std::log10(size)));
  return fmt::format("{:.{}f}", value, std::max(0, digits - 1 - leading));
}

std::string padded(const Cell& cell, const Column& column) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    return fmt::format("{:<{}}", *text, column.width);
  }
  if (const auto* count = std::get_if<Index>(&cell)) {
    return fmt::format("{:>{}}", *count, column.width);
  }
  return fmt::format("{:>{}}", number_text(std::get<double>(cell), column.digits), column.width);
}

nlohmann::ordered_json as_json(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* count = std::get_if<Index>(&cell)) return *count;
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

void print_line(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  std::puts(line.c_str());
  std::fflush(stdout);
}

}  // namespace

void Report::table(const std::string& title, std::vector<Column> columns,
                   const std::vector<std::string>& notes) {
  columns_ = std::move(columns);
  tables_.push_back({{"title", title}, {"notes", notes}, {"rows", nlohmann::json::array()}});
  print_line("");
  print_line(title);
  for (const std::string& note : notes) print_line("  " + note);
  std::string heading;
  for (const Column& column : columns_) {
    heading += fmt::format("{:<{}}  ", column.name, column.width);
  }
  print_line(heading);
}

void Report::row(const std::vector<Cell>& cells) {
  std::string line;
  nlohmann::ordered_json record;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    line += padded(cells.at(i), columns_[i]) + "  ";
    record[columns_[i].name] = as_json(cells[i]);
  }
  tables_.back()["rows"].push_back(record);
  print_line(line);
}

void Report::write_json(const std::string& path) const {
  std::ofstream file(path);
  file << tables_.dump(2) << '\n';
  if (!file.flush()) throw OutputError("Cannot write " + path + ".");
}

}  // namespace tetraction::benchmarks
