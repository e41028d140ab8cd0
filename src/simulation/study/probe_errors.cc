#include "probe_errors.h"

#include <algorithm>

namespace tetraction {

void ProbeObserver::on_start(const Session& session) {
  if (name_.empty()) return;
  const std::vector<ProbeColumns>& probes = session.probes().probes();
  const auto found = std::find_if(probes.begin(), probes.end(),
                                  [&](const ProbeColumns& probe) { return probe.name == name_; });
  probe_ = static_cast<std::size_t>(found - probes.begin());
  all_values_.resize(session.probes().value_count());
  evaluate(session);
}

bool ProbeObserver::on_step(const Session& session) {
  if (name_.empty()) return true;
  if (session.status() != RunStatus::kRunning ||
      session.probes().is_due(probe_, session.step_number())) {
    evaluate(session);
  }
  return true;
}

void ProbeObserver::evaluate(const Session& session) {
  const ProbeColumns& columns = session.probes().probes()[probe_];
  session.probes().evaluate(probe_, session, all_values_.data());
  values_ = Eigen::Map<const Vector>(all_values_.data() + columns.first,
                                     static_cast<Index>(columns.size()));
  take(session.time(), values_);
}

void ReferenceProbe::take(double time, const Vector& values) {
  times_.push_back(time);
  values_.push_back(values);
  largest_ = std::max(largest_, values.norm());
}

Vector ReferenceProbe::at(double time) const {
  const auto after = std::lower_bound(times_.begin(), times_.end(), time);
  if (after == times_.end()) return values_.back();
  const auto right = static_cast<std::size_t>(after - times_.begin());
  if (right == 0) return values_.front();
  const double share = (time - times_[right - 1]) / (times_[right] - times_[right - 1]);
  return (1.0 - share) * values_[right - 1] + share * values_[right];
}

double ReferenceProbe::largest_difference(const ReferenceProbe& other) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < times_.size(); ++i) {
    largest = std::max(largest, (values_[i] - other.at(times_[i])).norm());
  }
  return largest;
}

double ReferenceProbe::interpolation_error() const {
  double largest = 0.0;
  for (std::size_t i = 2; i < values_.size(); ++i) {
    largest = std::max(largest, (values_[i - 2] - 2.0 * values_[i - 1] + values_[i]).norm());
  }
  return largest / 8.0;
}

void ReferenceProbe::extrapolate(double share, const ReferenceProbe& coarser) {
  ReferenceProbe difference{std::string()};
  for (std::size_t i = 0; i < coarser.times_.size(); ++i) {
    difference.take(coarser.times_[i], at(coarser.times_[i]) - coarser.values_[i]);
  }
  largest_ = 0.0;
  for (std::size_t i = 0; i < times_.size(); ++i) {
    values_[i] += share * difference.at(times_[i]);
    largest_ = std::max(largest_, values_[i].norm());
  }
}

void ProbeDifference::take(double time, const Vector& values) {
  if (!reference_.has_values()) return;
  largest_ = std::max(largest_, (values - reference_.at(time)).norm());
}

}  // namespace tetraction
