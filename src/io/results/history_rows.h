// The text of history.csv.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include "tetraction/simulation/history.h"

namespace tetraction {

inline std::string header_text(const HistoryColumns& columns) {
  return fmt::format("{}\n", fmt::join(columns.names(), ","));
}

/// Numbers with 17 digits, which read back as they were. Whole numbers have no point. Steps, which people choose, have as
/// few digits as read back so. The place of a number that there is not, such as the gap of a body that touches
/// nothing, is empty.
inline std::string row_text(const HistoryColumns& columns, const std::vector<double>& values) {
  std::string row;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) row += ',';
    if (!std::isfinite(values[i])) continue;
    row += columns.names()[i] == "time_step" ? fmt::format("{}", values[i])
                                             : fmt::format("{:.17g}", values[i]);
  }
  return row + '\n';
}

}  // namespace tetraction
