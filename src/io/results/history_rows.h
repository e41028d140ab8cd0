// The text of history.csv.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "tetraction/simulation/history.h"

namespace tetraction {

inline std::string header_text(const HistoryColumns& columns) {
  return fmt::format("{}\n", fmt::join(columns.names(), ","));
}

/// Numbers with 17 digits, which read back as they were. Whole numbers have no point.
inline std::string row_text(const std::vector<double>& values) {
  std::string row;
  for (const double value : values) row += fmt::format("{}{:.17g}", row.empty() ? "" : ",", value);
  return row + '\n';
}

}  // namespace tetraction
