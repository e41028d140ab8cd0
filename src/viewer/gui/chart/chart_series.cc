#include "chart_series.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetraction::viewer {
namespace {

using Row = const HistoryRow&;
// Colours that colour-blind people can distinguish (Okabe and Ito).
constexpr std::array<unsigned char, 3> kBlue{0, 114, 178}, kOrange{230, 159, 0},
    kGreen{0, 158, 115}, kBlack{40, 40, 40}, kRed{213, 94, 0}, kPink{204, 121, 167};

constexpr ChartSeries kEnergies[] = {{"Kinetic", kBlue, [](Row r) { return r.kinetic; }},
                                     {"Elastic", kOrange, [](Row r) { return r.elastic; }},
                                     {"Environment", kGreen, [](Row r) { return r.environment; }},
                                     {"Total", kBlack, [](Row r) { return r.total; }}};
constexpr ChartSeries kBalance[] = {
    {"External work", kBlue, [](Row r) { return r.external_work; }},
    {"Constraint work", kOrange, [](Row r) { return r.constraint_work; }},
    {"Dissipated", kGreen, [](Row r) { return r.dissipated_energy; }},
    {"Work of edits", kPink, [](Row r) { return r.edit_work; }},
    {"Energy error", kRed, [](Row r) { return r.energy_error; }}};
constexpr ChartSeries kLinear[] = {{"p x", kBlue, [](Row r) { return r.linear_momentum.x(); }},
                                   {"p y", kOrange, [](Row r) { return r.linear_momentum.y(); }},
                                   {"p z", kGreen, [](Row r) { return r.linear_momentum.z(); }}};
constexpr ChartSeries kAngular[] = {{"L x", kBlue, [](Row r) { return r.angular_momentum.x(); }},
                                    {"L y", kOrange, [](Row r) { return r.angular_momentum.y(); }},
                                    {"L z", kGreen, [](Row r) { return r.angular_momentum.z(); }}};
constexpr ChartSeries kIterations[] = {
    {"Iterations", kBlue, [](Row r) { return static_cast<double>(r.iterations); }}};

}  // namespace

const std::array<ChartKind, kChartKinds>& chart_kinds() {
  static const std::array<ChartKind, kChartKinds> kinds{
      {{"Energy", "Energy [J]", kEnergies},
       {"Energy balance", "Since the start [J]", kBalance},
       {"Linear momentum", "Momentum [kg m/s]", kLinear},
       {"Angular momentum", "About the origin [kg m²/s]", kAngular},
       {"Iterations", "Iterations a step", kIterations}}};
  return kinds;
}

std::string history_text(const std::vector<HistoryRow>& rows) {
  std::string text =
      "step,time,kinetic_energy,elastic_energy,environment_energy,total_energy,external_work,"
      "dissipated_energy,constraint_work,edit_work,energy_error,px,py,pz,lx,ly,lz,iterations\n";
  for (const HistoryRow& r : rows) {
    text += fmt::format("{}", r.step);
    for (const double value :
         {r.time, r.kinetic, r.elastic, r.environment, r.total, r.external_work,
          r.dissipated_energy, r.constraint_work, r.edit_work, r.energy_error,
          r.linear_momentum.x(), r.linear_momentum.y(), r.linear_momentum.z(),
          r.angular_momentum.x(), r.angular_momentum.y(), r.angular_momentum.z()}) {
      text += fmt::format(",{:.17g}", value);
    }
    text += fmt::format(",{}\n", r.iterations);
  }
  return text;
}

ThinnedSeries thin(const std::vector<HistoryRow>& rows, std::span<const ChartSeries> series,
                   std::size_t buckets) {
  ThinnedSeries result;
  result.values.resize(series.size());
  const std::size_t n = rows.size();
  if (n <= 2 * buckets) {
    for (const HistoryRow& row : rows) result.time.push_back(row.time);
    for (std::size_t s = 0; s < series.size(); ++s) {
      for (const HistoryRow& row : rows) result.values[s].push_back(series[s].value(row));
    }
    return result;
  }
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t begin = b * n / buckets;
    const std::size_t end = (b + 1) * n / buckets;
    result.time.push_back(rows[begin].time);
    result.time.push_back(rows[end - 1].time);
    for (std::size_t s = 0; s < series.size(); ++s) {
      const auto value = series[s].value;
      const auto first = rows.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = rows.begin() + static_cast<std::ptrdiff_t>(end);
      const auto [least, most] =
          std::minmax_element(first, last, [value](Row a, Row c) { return value(a) < value(c); });
      // The two values have the order that they have in the history.
      result.values[s].push_back(value(least < most ? *least : *most));
      result.values[s].push_back(value(least < most ? *most : *least));
    }
  }
  return result;
}

}  // namespace tetraction::viewer
