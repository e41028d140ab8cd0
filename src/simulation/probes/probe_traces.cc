// The values of probes over time, and what the summary says of them.
#include <algorithm>
#include <cmath>

#include "core/not_known.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

constexpr std::size_t kMostNumbers = std::size_t{1} << 25U;  // of all traces, 256 MiB
constexpr std::size_t kMostTimes = std::size_t{1} << 20U;    // of one trace
// A component that moves by less than this share of the largest value of its probe is round-off.
constexpr double kRoundOff = 1e-12;

}  // namespace

ProbeTraces::ProbeTraces(const ProbeSet& probes, Index step_count)
    : probes_(probes),
      traces_(probes.probes().size()),
      fillings_(probes.probes().size()),
      extremes_(probes.value_count(),
                {kNotKnown, kNotKnown, kNotKnown, kNotKnown, kNotKnown, kNotKnown}) {
  const std::size_t numbers = probes.value_count() + traces_.size();
  for (std::size_t i = 0; i < traces_.size(); ++i) {
    const ProbeColumns& columns = probes.probes()[i];
    const std::size_t room = std::min(kMostTimes, kMostNumbers / numbers);
    fillings_[i].capacity = room / 2 * 2;  // even, so that all entries have a neighbour
    const Index due = std::max<Index>(0, step_count) / columns.every + 2;  // the first and the last
    const auto expected =
        static_cast<std::size_t>(std::min(due, static_cast<Index>(fillings_[i].capacity)));
    traces_[i].times.reserve(expected);
    traces_[i].values.reserve(expected * columns.size());
  }
}

void ProbeTraces::add(Index step, double time, const double* values, bool all) {
  for (std::size_t i = 0; i < traces_.size(); ++i) {
    if (all || probes_.is_due(i, step)) add_to_trace(i, time, values);
  }
}

void ProbeTraces::add_to_trace(std::size_t probe, double time, const double* values) {
  const ProbeColumns& columns = probes_.probes()[probe];
  ProbeTrace& trace = traces_[probe];
  Filling& filling = fillings_[probe];
  const std::size_t size = columns.size();
  const double* first = values + columns.first;
  for (std::size_t c = 0; c < size; ++c) {
    ProbeStatistics& extremes = extremes_[columns.first + c];
    if (!(extremes.min <= first[c])) {
      extremes.min = first[c];
      extremes.min_time = time;
    }
    if (!(extremes.max >= first[c])) {
      extremes.max = first[c];
      extremes.max_time = time;
    }
    extremes.last = first[c];
  }
  if (filling.pending > 0) {
    // The entry is the mean of the values so far.
    const double share = 1.0 / static_cast<double>(filling.pending + 1);
    trace.times.back() += share * (time - trace.times.back());
    double* entry = trace.values.data() + trace.values.size() - size;
    for (std::size_t c = 0; c < size; ++c) entry[c] += share * (first[c] - entry[c]);
  } else {
    trace.times.push_back(time);
    trace.values.insert(trace.values.end(), first, first + size);
  }
  filling.pending = (filling.pending + 1) % filling.merged;
  if (filling.pending > 0 || trace.times.size() < filling.capacity) return;
  const std::size_t half = trace.times.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    trace.times[i] = 0.5 * (trace.times[2 * i] + trace.times[2 * i + 1]);
    for (std::size_t c = 0; c < size; ++c) {
      trace.values[i * size + c] =
          0.5 * (trace.values[2 * i * size + c] + trace.values[(2 * i + 1) * size + c]);
    }
  }
  trace.times.resize(half);
  trace.values.resize(half * size);
  filling.merged *= 2;
}

std::vector<ProbeStatistics> ProbeTraces::statistics() const {
  std::vector<ProbeStatistics> result = extremes_;
  std::vector<double> column;
  for (std::size_t i = 0; i < traces_.size(); ++i) {
    const ProbeColumns& columns = probes_.probes()[i];
    const ProbeTrace& trace = traces_[i];
    const std::size_t size = columns.size();
    double largest = 0.0;
    for (const double value : trace.values) largest = std::max(largest, std::abs(value));
    for (std::size_t c = 0; c < size; ++c) {
      column.resize(trace.times.size());
      for (std::size_t k = 0; k < column.size(); ++k) column[k] = trace.values[k * size + c];
      result[columns.first + c].frequency =
          dominant_frequency(trace.times, column, kRoundOff * largest);
    }
  }
  return result;
}

}  // namespace tetraction
