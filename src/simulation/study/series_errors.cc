#include "series_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetraction {
namespace {

constexpr double kUnknownError = std::numeric_limits<double>::quiet_NaN();

using SeriesValues = Eigen::Map<const Matrix>;

SeriesValues values_of_series(const ProbeTrace& trace, std::size_t width) {
  return {trace.values.data(), static_cast<Index>(width), static_cast<Index>(trace.times.size())};
}

double over_time(const ProbeTrace& run, const ProbeTrace& reference, std::size_t width) {
  const SeriesValues own = values_of_series(run, width);
  const SeriesValues exact = values_of_series(reference, width);
  double largest = 0.0;
  std::size_t right = 0;
  for (std::size_t i = 0; i < run.times.size(); ++i) {
    while (right + 1 < reference.times.size() && reference.times[right] < run.times[i]) ++right;
    const std::size_t left = right == 0 ? 0 : right - 1;
    const double width_in_time = reference.times[right] - reference.times[left];
    const double share =
        width_in_time > 0.0
            ? std::clamp((run.times[i] - reference.times[left]) / width_in_time, 0.0, 1.0)
            : 1.0;
    const Vector expected = (1.0 - share) * exact.col(static_cast<Index>(left)) +
                            share * exact.col(static_cast<Index>(right));
    largest = std::max(largest, (own.col(static_cast<Index>(i)) - expected).norm());
  }
  return largest;
}

}  // namespace

double peak(const ProbeTrace& trace, std::size_t width) {
  if (trace.times.empty()) return kUnknownError;
  return values_of_series(trace, width).colwise().norm().maxCoeff();
}

std::size_t liveliest_component(const ProbeTrace& trace, std::size_t width) {
  if (trace.times.empty()) return 0;
  const SeriesValues values = values_of_series(trace, width);
  const Vector variances = (values.colwise() - values.rowwise().mean()).rowwise().squaredNorm();
  Index component = 0;
  variances.maxCoeff(&component);
  return static_cast<std::size_t>(component);
}

double main_frequency(const ProbeTrace& trace, std::size_t width, std::size_t component) {
  if (trace.times.empty()) return kUnknownError;
  const Vector row = values_of_series(trace, width).row(static_cast<Index>(component));
  return dominant_frequency(trace.times, std::vector<double>(row.begin(), row.end()));
}

double series_error(ErrorKind kind, const ProbeTrace& run, const ProbeTrace& reference,
                    std::size_t width) {
  if (run.times.empty() || reference.times.empty()) return kUnknownError;
  double difference = kUnknownError;
  double scale = peak(reference, width);
  if (kind == ErrorKind::kFrequency) {
    const std::size_t component = liveliest_component(reference, width);
    scale = main_frequency(reference, width, component);
    difference = std::abs(main_frequency(run, width, component) - scale);
  } else if (kind == ErrorKind::kPeak) {
    difference = std::abs(peak(run, width) - scale);
  } else {
    difference = over_time(run, reference, width);
  }
  return scale > 0.0 ? difference / scale : kUnknownError;
}

}  // namespace tetraction
