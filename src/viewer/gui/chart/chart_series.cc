#include "chart_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "viewer/display_units.h"

namespace tetraction::viewer {
namespace {

using Row = const HistoryRow&;
// Colours that colour-blind people can distinguish (Okabe and Ito).
constexpr std::array<unsigned char, 3> kBlue{0, 114, 178}, kOrange{230, 159, 0},
    kGreen{0, 158, 115}, kRed{213, 94, 0}, kPink{204, 121, 167};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double probe_value(Row row, std::size_t i) {
  return i < row.probes.size() ? row.probes[i] : kNone;
}

}  // namespace

const std::vector<ChartKind>& chart_kinds(RunKind run) {
  static const std::vector<ChartSeries> potentials{
      {"Elastic", kOrange, [](Row r) { return r.elastic; }},
      {"Environment", kGreen, [](Row r) { return r.environment; }},
      {"Total", kBlack, [](Row r) { return r.total; }}};
  static const ChartSeries iterations{
      "Iterations", kBlue,
      // A row that comes from probes.csv only has no iterations.
      [](Row r) { return std::isnan(r.total) ? kNone : static_cast<double>(r.iterations); }};
  static const std::vector<ChartKind> of_equilibrium{
      {"Energy", "Energy", "Energy", "J", potentials},
      {"Iterations", "Iterations", "Iterations a load step", "", {iterations}}};
  static const std::vector<ChartKind> of_motion{
      {"Energy",
       "Energy",
       "Energy",
       "J",
       {{"Kinetic", kBlue, [](Row r) { return r.kinetic; }},
        potentials[0],
        potentials[1],
        potentials[2]}},
      {"Balance",
       "Balance",
       "Since the start",
       "J",
       {{"External work", kBlue, [](Row r) { return r.external_work; }},
        {"Constraint work", kOrange, [](Row r) { return r.constraint_work; }},
        {"Dissipated", kGreen, [](Row r) { return r.dissipated_energy; }},
        {"Work of edits", kPink, [](Row r) { return r.edit_work; }},
        {"Energy error", kRed, [](Row r) { return r.energy_error; }}}},
      {"Error",
       "Energy error",
       "Energy error",
       "J",
       {{"Energy error", kRed, [](Row r) { return r.energy_error; }}}},
      {"Momentum",
       "Momentum",
       "Momentum",
       "kg m/s",
       {{"p x", kBlue, [](Row r) { return r.linear_momentum.x(); }},
        {"p y", kOrange, [](Row r) { return r.linear_momentum.y(); }},
        {"p z", kGreen, [](Row r) { return r.linear_momentum.z(); }}}},
      {"Angular",
       "Angular momentum",
       "About the origin",
       "kg m²/s",
       {{"L x", kBlue, [](Row r) { return r.angular_momentum.x(); }},
        {"L y", kOrange, [](Row r) { return r.angular_momentum.y(); }},
        {"L z", kGreen, [](Row r) { return r.angular_momentum.z(); }}}},
      {"Iterations", "Iterations", "Iterations a step", "", {iterations}}};
  return run == RunKind::kEquilibrium ? of_equilibrium : of_motion;
}

std::string axis_title(const std::string& axis, const std::string& unit) {
  return unit.empty() ? axis : fmt::format("{} [{}]", axis, display_unit(unit).text);
}

std::vector<ChartProbe> chart_probes(const std::vector<ProbeSettings>& probes) {
  std::vector<ChartProbe> result;
  std::size_t first = 0;
  for (const ProbeSettings& probe : probes) {
    ChartProbe& entry = result.emplace_back();
    entry.name = probe.name;
    std::string quantity = to_string(probe.quantity);
    std::replace(quantity.begin(), quantity.end(), '_', ' ');
    entry.axis = fmt::format("{}: {}", probe.name, quantity);
    entry.unit = quantity_of(probe.quantity).unit;
    entry.first = first;
    for (const char* ending : component_endings(quantity_of(probe.quantity).shape)) {
      entry.columns.push_back(probe.name + ending);
    }
    first += entry.columns.size();
  }
  return result;
}

ChartKind chart_kind_of(const ChartProbe& probe) {
  constexpr std::array kColors{kBlue, kOrange, kGreen, kBlack, kRed, kPink};
  ChartKind kind{probe.name, probe.name, probe.axis, probe.unit, {}};
  for (std::size_t c = 0; c < probe.columns.size(); ++c) {
    const std::size_t i = probe.first + c;
    kind.series.push_back(
        {probe.columns[c], kColors[c % kColors.size()], [i](Row r) { return probe_value(r, i); }});
  }
  return kind;
}

std::string history_text(const std::vector<HistoryRow>& rows,
                         const std::vector<ChartProbe>& probes) {
  std::string text = fmt::format("step,{},iterations", kHistoryNumbers);
  for (const ChartProbe& probe : probes) text += fmt::format(",{}", fmt::join(probe.columns, ","));
  text += '\n';
  for (const HistoryRow& r : rows) {
    text += fmt::format("{}", r.step);
    const auto add = [&text](double value) {
      text += std::isnan(value) ? "," : fmt::format(",{:.17g}", value);
    };
    for (const double* value : numbers_of(r)) add(*value);
    text += std::isnan(r.total) ? "," : fmt::format(",{}", r.iterations);
    for (const ChartProbe& probe : probes) {
      for (std::size_t c = 0; c < probe.columns.size(); ++c) add(probe_value(r, probe.first + c));
    }
    text += '\n';
  }
  return text;
}

ThinnedSeries thin(const std::vector<HistoryRow>& rows, std::span<const ChartSeries> series,
                   std::size_t buckets) {
  ThinnedSeries result;
  result.values.resize(series.size());
  std::vector<const HistoryRow*> kept;
  kept.reserve(rows.size());
  for (const HistoryRow& row : rows) {
    if (series.empty() || !std::isnan(series.front().value(row))) kept.push_back(&row);
  }
  const std::size_t n = kept.size();
  if (n <= 2 * buckets) {
    for (const HistoryRow* row : kept) result.time.push_back(row->time);
    for (std::size_t s = 0; s < series.size(); ++s) {
      for (const HistoryRow* row : kept) result.values[s].push_back(series[s].value(*row));
    }
    return result;
  }
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t begin = b * n / buckets;
    const std::size_t end = (b + 1) * n / buckets;
    result.time.push_back(kept[begin]->time);
    result.time.push_back(kept[end - 1]->time);
    for (std::size_t s = 0; s < series.size(); ++s) {
      const auto& value = series[s].value;
      const auto first = kept.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = kept.begin() + static_cast<std::ptrdiff_t>(end);
      const auto [least, most] = std::minmax_element(
          first, last,
          [&value](const HistoryRow* a, const HistoryRow* c) { return value(*a) < value(*c); });
      // The two values have the order that they have in the history.
      result.values[s].push_back(value(least < most ? **least : **most));
      result.values[s].push_back(value(least < most ? **most : **least));
    }
  }
  return result;
}

std::vector<double> axis_ticks(double low, double high, int wanted) {
  const double rough = (high - low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  std::vector<double> ticks;
  // A finer step is taken where the wanted one gives fewer than two ticks.
  for (const double digits : {5.0, 2.0, 1.0, 0.5, 0.2}) {
    const double step = digits * power;
    if (digits > 1.0 && step > 2.0 * rough) continue;
    ticks.clear();
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) {
      ticks.push_back(k * step);
    }
    if (ticks.size() >= 2) break;
  }
  return ticks;
}

}  // namespace tetraction::viewer
