#include "tetraction/simulation/motion_track.h"

#include <algorithm>
#include <cmath>

#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {
namespace {

// Relative difference up to which two times count as equal. Multiples of different steps differ by
// round-off.
constexpr double kSameTime = 1e-9;

// In the order of energy_columns().
std::vector<double> energies_of(const Balance& balance) {
  const Energies& energies = balance.energies();
  std::vector<double> values{energies.kinetic(),        energies.elastic(),
                             energies.environment(),    energies.total(),
                             balance.external_work(),   balance.dissipated_energy(),
                             balance.constraint_work(), balance.edit_work()};
  for (std::size_t i = 0; i < energies.extra_count(); ++i)
    values.push_back(energies.extra(i).value);
  return values;
}

// Leaves each second sample.
void thin(ProbeRecord& record) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < record.times.size(); i += 2, ++kept) {
    record.times[kept] = record.times[i];
    record.values[kept] = record.values[i];
  }
  record.times.resize(kept);
  record.values.resize(kept);
}

}  // namespace

Vector ProbeRecord::at(double time) const {
  const auto after = std::lower_bound(times.begin(), times.end(), time);
  if (after == times.end()) return sample(times.size() - 1);
  const auto right = static_cast<std::size_t>(after - times.begin());
  if (right == 0) return sample(0);
  const double share = (time - times[right - 1]) / (times[right] - times[right - 1]);
  return (1.0 - share) * sample(right - 1) + share * sample(right);
}

double ProbeRecord::largest() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) largest = std::max(largest, sample(i).norm());
  return largest;
}

double ProbeRecord::largest_difference(const ProbeRecord& other) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    largest = std::max(largest, (sample(i) - other.at(times[i])).norm());
  }
  return largest;
}

double ProbeRecord::interpolation_error() const {
  double largest = 0.0;
  for (std::size_t i = 2; i < times.size(); ++i) {
    largest = std::max(largest, (sample(i - 2) - 2.0 * sample(i - 1) + sample(i)).norm());
  }
  return largest / 8.0;
}

void ProbeRecord::extrapolate(double share, const ProbeRecord& coarser) {
  ProbeRecord difference = coarser;
  for (std::size_t i = 0; i < coarser.times.size(); ++i) {
    Eigen::Map<Vector>(difference.values.data() + i * width, static_cast<Index>(width)) =
        at(coarser.times[i]) - coarser.sample(i);
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    Eigen::Map<Vector>(values.data() + i * width, static_cast<Index>(width)) +=
        share * difference.at(times[i]);
  }
}

const ProbeRecord* MotionTrack::probe(const std::string& name) const {
  const auto found = std::find_if(probes.begin(), probes.end(),
                                  [&](const ProbeRecord& record) { return record.name == name; });
  return found == probes.end() ? nullptr : &*found;
}

void MotionTrack::extrapolate(double share, const MotionTrack& coarser) {
  for (std::size_t k = 0; k < positions.size(); ++k) {
    positions[k] += share * (positions[k] - coarser.positions[k]);
  }
}

std::vector<std::string> energy_columns(const Energies& energies) {
  std::vector<std::string> names{"kinetic_energy",  "elastic_energy", "environment_energy",
                                 "total_energy",    "external_work",  "dissipated_energy",
                                 "constraint_work", "edit_work"};
  for (std::size_t i = 0; i < energies.extra_count(); ++i) {
    names.push_back(energies.extra(i).name + "_energy");
  }
  return names;
}

std::size_t track_times(Index dof_count) {
  constexpr double kMostBytes = 64e6;
  const double room = kMostBytes / (8.0 * static_cast<double>(dof_count));
  return static_cast<std::size_t>(std::clamp(std::floor(room), 10.0, 100.0));
}

TrackScales scales_of(const MotionTrack& track) {
  double squares = 0.0;
  for (const Vector& q : track.positions) squares += (q - track.rest).squaredNorm();
  const double mean = std::sqrt(squares / static_cast<double>(track.count));
  const auto points = track.rest.reshaped(3, track.rest.size() / 3);
  const double diagonal = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  const double least = 1e-12 * std::sqrt(static_cast<double>(points.cols())) * diagonal;
  return {std::max({(track.last() - track.rest).norm(), 0.1 * mean, least}), std::max(mean, least)};
}

double MotionRecorder::next_time() const {
  return track_.end * static_cast<double>(track_.positions.size() + 1) /
         static_cast<double>(track_.count);
}

void MotionRecorder::on_start(const Session& session) {
  const MechanicalSystem& system = session.system();
  track_ = {};
  track_.end = session.time_settings().end;
  track_.rest = system.mesh().rest_positions();
  track_.count = track_times(track_.rest.size());
  inverse_mass_ = system.inverse_mass().transpose().replicate(3, 1).reshaped();
  for (const ProbeColumns& probe : session.probes().probes()) {
    track_.probes.push_back({probe.name, probe.size(), {}, {}});
  }
  energy_stride_ = 1;
  for (const std::string& name : energy_columns(session.balance().energies())) {
    track_.probes.push_back({ErrorMeasure{ErrorKind::kEnergy, name}.series(), 1, {}, {}});
  }
  probe_values_.resize(session.probes().value_count());
  record_probes(session, true);
  record_energies(session, true);
  keep_state(session);
}

bool MotionRecorder::on_step(const Session& session) {
  const State& state = session.present_state();
  const double same = kSameTime * track_.end;
  while (!track_.is_whole() && next_time() <= state.time + same) {
    const double t = next_time();
    if (t >= state.time - same) {
      track_.positions.push_back(state.position);
      continue;
    }
    const Vector velocity = inverse_mass_.cwiseProduct(state.momentum);
    const double h = state.time - time_;
    const double s = std::max(0.0, (t - time_) / h);
    const double r = 1.0 - s;
    track_.positions.push_back(r * r * (1.0 + 2.0 * s) * position_ +
                               s * s * (1.0 + 2.0 * r) * state.position +
                               h * s * r * (r * velocity_ - s * velocity));
  }
  keep_state(session);
  const bool is_last = session.status() != RunStatus::kRunning;
  record_probes(session, is_last);
  record_energies(session, is_last);
  return true;
}

// Only the state before a step that passes a time of the track is needed. The size of adaptive steps is not known.
void MotionRecorder::keep_state(const Session& session) {
  const State& state = session.present_state();
  if (track_.is_whole()) return;
  const bool is_fixed = !session.may_repeat_steps();
  if (is_fixed && next_time() > state.time + 2.0 * session.time_step()) return;
  time_ = state.time;
  position_ = state.position;
  velocity_ = inverse_mass_.cwiseProduct(state.momentum);
}

void MotionRecorder::record_probes(const Session& session, bool all) {
  const ProbeSet& probes = session.probes();
  for (std::size_t i = 0; i < probes.probes().size(); ++i) {
    if (!all && !probes.is_due(i, session.step_number())) continue;
    const ProbeColumns& columns = probes.probes()[i];
    probes.evaluate(i, session, probe_values_.data());
    ProbeRecord& record = track_.probes[i];
    record.times.push_back(session.time());
    const auto first = probe_values_.begin() + static_cast<std::ptrdiff_t>(columns.first);
    record.values.insert(record.values.end(), first,
                         first + static_cast<std::ptrdiff_t>(columns.size()));
  }
}

void MotionRecorder::record_energies(const Session& session, bool all) {
  constexpr std::size_t kMostSamples = 10000;
  if (!all && session.step_number() % energy_stride_ != 0) return;
  const std::vector<double> values = energies_of(session.balance());
  const std::size_t first = session.probes().probes().size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    ProbeRecord& record = track_.probes[first + i];
    record.times.push_back(session.time());
    record.values.push_back(values[i]);
  }
  if (all || track_.probes[first].times.size() <= kMostSamples) return;
  for (std::size_t i = 0; i < values.size(); ++i) thin(track_.probes[first + i]);
  energy_stride_ *= 2;
}

}  // namespace tetraction
