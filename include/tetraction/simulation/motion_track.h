// The motion of a run of a study at fixed times, by which runs are compared after they were made.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// The values of one probe at the steps at which it is due, and at the last one; or those of an energy.
struct ProbeRecord {
  std::string name;
  std::size_t width = 0;       ///< number of values at each time
  std::vector<double> times;   ///< ascending, s
  std::vector<double> values;  ///< `width` numbers for each time

  Eigen::Map<const Vector> sample(std::size_t i) const {
    return {values.data() + i * width, static_cast<Index>(width)};
  }
  /// The values at a time, interpolated linearly. After the last time they are those at the end.
  /// There must be values.
  Vector at(double time) const;
  /// The largest magnitude of the values as vectors.
  double largest() const;
  /// The largest magnitude of the difference from `other` at the times of this one. Both have values.
  double largest_difference(const ProbeRecord& other) const;
  /// An estimate of the error of at() between the times: the largest second difference of the values,
  /// |s₀ − 2 s₁ + s₂|/8.
  double interpolation_error() const;
  /// Takes this + share·(this − coarser). The difference is computed at the times of `coarser` and
  /// interpolated linearly between them: it is far smaller than the values.
  void extrapolate(double share, const ProbeRecord& coarser);
};

/// The motion of a run at the times end·k/n, k = 1, …, n, which do not depend on the run's step. Between
/// the steps of the run its positions are interpolated by cubic Hermite polynomials with the velocities
/// M⁻¹p, whose error is of fourth order in the step. Those at the end are the exact ones.
struct MotionTrack {
  double end = 0.0;               ///< s
  std::size_t count = 0;          ///< n
  Vector rest;                    ///< positions at rest, X
  std::vector<Vector> positions;  ///< at the times that the run has reached
  /// The probes of the scene, then the energies (ErrorMeasure::series()), which have at most
  /// 10,000 samples: of longer runs each second, fourth, … step.
  std::vector<ProbeRecord> probes;

  /// Whether the run reached the end.
  bool is_whole() const { return count > 0 && positions.size() == count; }
  /// The positions at the end. The track must be whole.
  const Vector& last() const { return positions.back(); }
  /// The probe of that name, or nullptr.
  const ProbeRecord* probe(const std::string& name) const;
  /// Takes this + share·(this − coarser) for all positions. Both are whole.
  void extrapolate(double share, const MotionTrack& coarser);
};

/// The names of the columns of history.csv that are energies of the body or entered it.
std::vector<std::string> energy_columns(const Energies& energies);

/// The number of times of a track: 100, but fewer, at least 10, if the positions would take more than 64 MB.
std::size_t track_times(Index dof_count);

/// The divisors that make differences from a track relative. They do not depend on the place of the origin.
struct TrackScales {
  /// |q − X|₂ at the end, but at least a tenth of √(mean of |q − X|²) over the times, because a body may
  /// pass its rest position just then, and at least 1e-12 √N times the body's diagonal (N vertices), below
  /// which displacements are round-off.
  double at_end = 0.0;
  double over_time = 0.0;  ///< √(mean of |q − X|²), with the same minimum
};
/// The scales of a track that is complete.
TrackScales scales_of(const MotionTrack& track);

/// Records the track of the run that it observes.
class MotionRecorder : public Observer {
 public:
  void on_start(const Session& session) override;
  bool on_step(const Session& session) override;

  const MotionTrack& track() const { return track_; }
  MotionTrack take() { return std::move(track_); }

 private:
  double next_time() const;
  void keep_state(const Session& session);
  void record_probes(const Session& session, bool all);
  void record_energies(const Session& session, bool all);

  MotionTrack track_;
  Vector inverse_mass_;
  // The state at the step before a time of the track.
  double time_ = 0.0;
  Vector position_;
  Vector velocity_;
  std::vector<double> probe_values_;
  Index energy_stride_ = 1;  // steps from one sample of the energies to the next
};

}  // namespace tetraction
