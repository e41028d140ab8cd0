// What the charts show: kinds of charts, their series, and thinning of long histories.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "viewer/snapshot.h"

namespace tetraction::viewer {

struct ChartSeries {
  const char* name;
  std::array<unsigned char, 3> color;
  double (*value)(const HistoryRow&);
};

struct ChartKind {
  const char* name;
  const char* axis;  ///< quantity and unit
  std::span<const ChartSeries> series;
};

inline constexpr std::size_t kChartKinds = 5;
/// Energy, energy balance, linear momentum, angular momentum, iterations.
const std::array<ChartKind, kChartKinds>& chart_kinds();

/// The rows as CSV, with the columns of history.csv that a history has.
std::string history_text(const std::vector<HistoryRow>& rows);

/// Times and values for drawing: at most about 2 `buckets` points. Longer histories are cut into
/// buckets, of each of which the least and the largest value are kept, so that no spike is lost.
struct ThinnedSeries {
  std::vector<double> time;
  std::vector<std::vector<double>> values;  ///< by series
};
ThinnedSeries thin(const std::vector<HistoryRow>& rows, std::span<const ChartSeries> series,
                   std::size_t buckets);

}  // namespace tetraction::viewer
