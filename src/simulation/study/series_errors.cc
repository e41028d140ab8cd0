#include "series_errors.h"

#include <algorithm>
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

// The largest |E − E(0)|.
double largest_change(const ProbeRecord& record) {
  if (record.times.empty()) return 0.0;
  const Matrix values = table_of(record);
  return (values.colwise() - values.col(0)).colwise().norm().maxCoeff();
}

double scale_of(ErrorKind kind, const ProbeRecord& reference) {
  const double change = kind == ErrorKind::kEnergy ? largest_change(reference) : 0.0;
  return change > 0.0 ? change : reference.largest();
}

double series_error(ErrorKind kind, const ProbeRecord& run, const ProbeRecord& reference,
                    double scale) {
  if (run.times.empty() || reference.times.empty()) return kUnknownError;
  double difference = kUnknownError;
  if (kind == ErrorKind::kFrequency) {
    const Index component = liveliest_component(reference);
    scale = frequency_of(reference, component);
    difference = std::abs(frequency_of(run, component) - scale);
  } else if (kind == ErrorKind::kPeak) {
    difference = std::abs(run.largest() - reference.largest());
  } else {
    difference = run.largest_difference(reference);
  }
  return scale > 0.0 ? difference / scale : kUnknownError;
}

}  // namespace

double series_error(ErrorKind kind, const ProbeRecord& run, const ProbeRecord& reference) {
  return series_error(kind, run, reference, scale_of(kind, reference));
}

double series_error(const ErrorMeasure& measure, const MotionTrack& run,
                    const MotionTrack& reference) {
  const ProbeRecord* own = run.probe(measure.series());
  const ProbeRecord* exact = reference.probe(measure.series());
  if (own == nullptr || exact == nullptr) return kUnknownError;
  return series_error(measure.kind, *own, *exact, series_scale(measure, reference));
}

double series_value(const ErrorMeasure& measure, const MotionTrack& run,
                    const MotionTrack& reference) {
  const ProbeRecord* own = run.probe(measure.series());
  const ProbeRecord* exact = reference.probe(measure.series());
  if (own == nullptr || exact == nullptr || own->times.empty() || exact->times.empty()) {
    return kUnknownError;
  }
  if (measure.kind == ErrorKind::kPeak) return own->largest();
  if (measure.kind != ErrorKind::kFrequency) return kUnknownError;
  return frequency_of(*own, liveliest_component(*exact));
}

double series_scale(const ErrorMeasure& measure, const MotionTrack& reference) {
  const ProbeRecord* record = reference.probe(measure.series());
  if (record == nullptr) return 0.0;
  double change = 0.0;
  if (measure.kind == ErrorKind::kEnergy && measure.name == "total_energy") {
    for (const char* part :
         {"total_energy", "kinetic_energy", "elastic_energy", "environment_energy"}) {
      const ProbeRecord* energy = reference.probe(ErrorMeasure{measure.kind, part}.series());
      if (energy != nullptr) change = std::max(change, largest_change(*energy));
    }
  }
  return change > 0.0 ? change : scale_of(measure.kind, *record);
}

}  // namespace tetraction
