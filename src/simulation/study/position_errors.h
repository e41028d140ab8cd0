// Differences between the positions of a study's runs and those of its reference, at the end and
// over time.
#pragma once

#include <utility>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// Times at which runs with these steps are compared with a reference, ascending: for each step up
/// to a hundred of its multiples, evenly distributed over the time, and the end. There are fewer if
/// `dof_count` numbers at all these times would take more than 256 MiB.
std::vector<double> comparison_times(const std::vector<double>& steps, double end, Index dof_count);

/// Stores the positions of a run at given times. Between its steps they are interpolated by cubic
/// Hermite polynomials with the velocities M⁻¹p, whose error is of fourth order in the step.
class ReferenceTrack : public Observer {
 public:
  /// Ascending times above 0.
  explicit ReferenceTrack(std::vector<double> times) : times_(std::move(times)) {}

  void on_start(const Session& session) override;
  bool on_step(const Session& session) override;

  /// The positions at a time that equals one of the given ones up to round-off and that the run has
  /// reached. Otherwise nullptr.
  const Vector* at(double time) const;
  /// √(mean of |q − X|²) over the times that were reached, with the rest positions X.
  double mean_displacement() const;
  /// The divisor for the relative error |q − q_ref|₂ of positions at the end of the run: |q_ref −
  /// X|₂, but at least a tenth of mean_displacement(), because a body may pass its rest position
  /// just then, and at least 1e-12 √N times the body's diagonal (N vertices), below which
  /// displacements are round-off. It does not depend on the place of the origin.
  double scale_at_end() const;
  /// The divisor for the root mean square error over time: mean_displacement(), with the same
  /// minimum.
  double scale_over_time() const;

  /// How many of the times were reached.
  std::size_t sample_count() const { return positions_.size(); }
  /// The positions at the i-th time.
  const Vector& sample(std::size_t i) const { return positions_[i]; }
  /// Whether the i-th time is the end of a step of the run, so that nothing was interpolated.
  bool is_step(std::size_t i) const { return is_step_[i]; }
  /// The positions at the end of the run.
  const Vector& last() const { return position_; }
  /// Takes weight·this + (1 − weight)·other for the positions at all times and at the end. `other`
  /// has as many samples.
  void combine(double weight, const ReferenceTrack& other);

 private:
  void keep(const Vector& position, bool is_step);

  std::vector<double> times_;
  std::vector<Vector> positions_;  // at the first of times_
  std::vector<bool> is_step_;      // for each of positions_
  Vector rest_;
  Vector inverse_mass_;
  double least_scale_ = 0.0;
  double squares_ = 0.0;  // sum of |q − X|² over positions_
  double time_ = 0.0;     // of the last step, with its positions and velocities
  Vector position_;
  Vector velocity_;
};

/// Sums the squared distances of a run from a reference that has been computed before.
class DistanceFromReference : public Observer {
 public:
  explicit DistanceFromReference(const ReferenceTrack& reference) : reference_(reference) {}
  bool on_step(const Session& session) override;

  /// √(mean of |q − q_ref|²) over the comparison times that are times of the run. NaN if there are
  /// none.
  double root_mean_square() const;

 private:
  const ReferenceTrack& reference_;
  double squares_ = 0.0;
  Index count_ = 0;
};

}  // namespace tetraction
