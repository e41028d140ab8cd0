// The kinds of charts, their series, and the thinning of long histories.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "viewer/snapshot.h"

namespace tetraction::viewer {

/// Of the series that is drawn in the colour of the texts.
inline constexpr std::array<unsigned char, 3> kBlack{40, 40, 40};

struct ChartSeries {
  std::string name;
  std::array<unsigned char, 3> color;
  std::function<double(const HistoryRow&)> value;
};

struct ChartKind {
  std::string tab;  ///< a short form of the name
  std::string name;
  std::string axis;  ///< title of the axis: the quantity
  std::string unit;
  std::vector<ChartSeries> series;
};

/// The kind of a history: a motion in time, load steps towards an equilibrium, whose `time` is the load factor, or
/// a mode, which has none and whose `time` is the part of the period.
enum class RunKind { kMotion, kEquilibrium, kMode };

/// The title of an axis with the unit in which it is shown.
std::string axis_title(const std::string& axis, const std::string& unit);

/// The kinds of a motion: energy, balance, energy error, momentum, angular momentum, iterations. An
/// equilibrium has energy without the kinetic part, and iterations.
const std::vector<ChartKind>& chart_kinds(RunKind run = RunKind::kMotion);

/// A probe whose values the rows of a history have.
struct ChartProbe {
  std::string name;
  std::string axis;  ///< the quantity
  std::string unit;
  std::size_t first = 0;             ///< index of its first value in HistoryRow::probes
  std::vector<std::string> columns;  ///< their names in probes.csv
  bool operator==(const ChartProbe&) const = default;
};
/// The probes of a scene. HistoryRow::probes has their values in the same order.
std::vector<ChartProbe> chart_probes(const std::vector<ProbeSettings>& probes);
/// The chart of one probe, with a series for each column.
ChartKind chart_kind_of(const ChartProbe& probe);

/// The rows as CSV, with those columns of history.csv and probes.csv that a HistoryRow has.
std::string history_text(const std::vector<HistoryRow>& rows,
                         const std::vector<ChartProbe>& probes = {});

/// The points of a chart, about 2 × `buckets` at most. A longer history is cut into buckets, and the
/// least and the largest value of each bucket are taken, so that peaks are not lost. Rows in which the
/// first series is NaN are left out.
struct ThinnedSeries {
  std::vector<double> time;
  std::vector<std::vector<double>> values;  ///< per series
};
ThinnedSeries thin(const std::vector<HistoryRow>& rows, std::span<const ChartSeries> series,
                   std::size_t buckets);

/// Round numbers in a range for the ticks of an axis: at least two and about `wanted`. The range must
/// not be empty.
std::vector<double> axis_ticks(double low, double high, int wanted);

}  // namespace tetraction::viewer
