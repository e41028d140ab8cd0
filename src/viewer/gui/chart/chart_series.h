// The kinds of charts, their series, and the thinning of long histories.
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
  const char* axis;  ///< title of the axis: quantity and unit
  std::span<const ChartSeries> series;
};

inline constexpr std::size_t kChartKinds = 5;
/// The kinds: energy, energy balance, linear momentum, angular momentum, iterations.
const std::array<ChartKind, kChartKinds>& chart_kinds();

/// The rows as CSV, with those columns of history.csv that a HistoryRow has.
std::string history_text(const std::vector<HistoryRow>& rows);

/// The points of a chart, about 2 × `buckets` at most. A longer history is cut into buckets, and the
/// least and the largest value of each bucket are taken, so that peaks are not lost.
struct ThinnedSeries {
  std::vector<double> time;
  std::vector<std::vector<double>> values;  ///< per series
};
ThinnedSeries thin(const std::vector<HistoryRow>& rows, std::span<const ChartSeries> series,
                   std::size_t buckets);

}  // namespace tetraction::viewer
