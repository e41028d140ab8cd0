#include "series_errors.h"

#include <cmath>
#include <limits>

#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

constexpr double kUnknownError = std::numeric_limits<double>::quiet_NaN();

Eigen::Map<const Matrix> table_of(const ProbeRecord& record) {
  return {record.values.data(), static_cast<Index>(record.width),
          static_cast<Index>(record.times.size())};
}

// The component with the largest variance.
Index liveliest_component(const ProbeRecord& record) {
  const Matrix values = table_of(record);
  const Vector variances = (values.colwise() - values.rowwise().mean()).rowwise().squaredNorm();
  Index component = 0;
  variances.maxCoeff(&component);
  return component;
}

double frequency_of(const ProbeRecord& record, Index component) {
  const Vector row = table_of(record).row(component);
  return dominant_frequency(record.times, std::vector<double>(row.begin(), row.end()));
}

}  // namespace

double series_error(ErrorKind kind, const ProbeRecord& run, const ProbeRecord& reference) {
  if (run.times.empty() || reference.times.empty()) return kUnknownError;
  double difference = kUnknownError;
  double scale = reference.largest();
  if (kind == ErrorKind::kFrequency) {
    const Index component = liveliest_component(reference);
    scale = frequency_of(reference, component);
    difference = std::abs(frequency_of(run, component) - scale);
  } else if (kind == ErrorKind::kPeak) {
    difference = std::abs(run.largest() - scale);
  } else {
    difference = run.largest_difference(reference);
  }
  return scale > 0.0 ? difference / scale : kUnknownError;
}

}  // namespace tetraction
