#include "position_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tetraction {
namespace {

// Relative difference up to which two times count as equal. Multiples of different steps differ by
// round-off.
constexpr double kSameTime = 1e-9;

}  // namespace

std::vector<double> comparison_times(const std::vector<double>& steps, double end,
                                     Index dof_count) {
  constexpr double kMostNumbers = 1U << 25U;
  const double room = kMostNumbers / (static_cast<double>(dof_count) *
                                      static_cast<double>(std::max<std::size_t>(1, steps.size())));
  const double most = std::clamp(std::floor(room), 4.0, 100.0);
  std::vector<double> times{end};
  for (const double step : steps) {
    const double count = std::floor(end / step * (1.0 + kSameTime));
    const double stride = std::max(1.0, std::ceil(count / most));
    for (double k = stride; k <= count; k += stride) times.push_back(k * step);
  }
  std::sort(times.begin(), times.end());
  const auto same = [end](double a, double b) { return b - a <= kSameTime * end; };
  times.erase(std::unique(times.begin(), times.end(), same), times.end());
  return times;
}

void ReferenceTrack::on_start(const Session& session) {
  const MechanicalSystem& system = session.system();
  rest_ = system.mesh().rest_positions();
  const auto points = rest_.reshaped(3, system.vertex_count());
  const double diagonal = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  least_scale_ = 1e-12 * std::sqrt(static_cast<double>(system.vertex_count())) * diagonal;
  inverse_mass_ = system.inverse_mass().transpose().replicate(3, 1).reshaped();
  time_ = session.state().time;
  position_ = session.state().position;
  velocity_ = inverse_mass_.cwiseProduct(session.state().momentum);
}

bool ReferenceTrack::on_step(const Session& session) {
  const State& state = session.state();
  const Vector velocity = inverse_mass_.cwiseProduct(state.momentum);
  const double h = state.time - time_;
  const double same = kSameTime * state.time;
  while (positions_.size() < times_.size() && times_[positions_.size()] <= state.time + same) {
    const double t = times_[positions_.size()];
    if (t >= state.time - same) {
      keep(state.position, true);
      continue;
    }
    const double s = std::max(0.0, (t - time_) / h);
    const double r = 1.0 - s;
    keep(r * r * (1.0 + 2.0 * s) * position_ + s * s * (1.0 + 2.0 * r) * state.position +
             h * s * r * (r * velocity_ - s * velocity),
         false);
  }
  time_ = state.time;
  position_ = state.position;
  velocity_ = velocity;
  return true;
}

void ReferenceTrack::keep(const Vector& position, bool is_step) {
  squares_ += (position - rest_).squaredNorm();
  positions_.push_back(position);
  is_step_.push_back(is_step);
}

void ReferenceTrack::combine(double weight, const ReferenceTrack& other) {
  squares_ = 0.0;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    positions_[i] += (1.0 - weight) * (other.positions_[i] - positions_[i]);
    squares_ += (positions_[i] - rest_).squaredNorm();
  }
  position_ += (1.0 - weight) * (other.position_ - position_);
}

const Vector* ReferenceTrack::at(double time) const {
  const double same = kSameTime * time;
  const auto found = std::lower_bound(times_.begin(), times_.end(), time - same);
  const auto index = static_cast<std::size_t>(found - times_.begin());
  if (index >= positions_.size() || *found > time + same) return nullptr;
  return &positions_[index];
}

double ReferenceTrack::mean_displacement() const {
  return positions_.empty() ? 0.0 : std::sqrt(squares_ / static_cast<double>(positions_.size()));
}

double ReferenceTrack::scale_at_end() const {
  return std::max({(position_ - rest_).norm(), 0.1 * mean_displacement(), least_scale_});
}

double ReferenceTrack::scale_over_time() const {
  return std::max(mean_displacement(), least_scale_);
}

bool DistanceFromReference::on_step(const Session& session) {
  if (const Vector* reference = reference_.at(session.state().time)) {
    squares_ += (session.state().position - *reference).squaredNorm();
    ++count_;
  }
  return true;
}

double DistanceFromReference::root_mean_square() const {
  if (count_ == 0) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(squares_ / static_cast<double>(count_));
}

}  // namespace tetraction
