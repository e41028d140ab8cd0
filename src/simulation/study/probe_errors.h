// Differences between the values of a probe in a study's runs and those in its reference.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"

namespace tetraction {

/// Evaluates one probe of the runs that it observes, at the steps at which it is due and at the last
/// one. If the name is empty, there is no probe, and nothing happens.
class ProbeObserver : public Observer {
 public:
  explicit ProbeObserver(std::string name) : name_(std::move(name)) {}

  void on_start(const Session& session) override;
  bool on_step(const Session& session) override;

 protected:
  /// Called with the values of the probe as a vector.
  virtual void take(double time, const Vector& values) = 0;

 private:
  void evaluate(const Session& session);

  std::string name_;
  std::size_t probe_ = 0;
  std::vector<double> all_values_;
  Vector values_;
};

/// Stores the values of a probe over the time of the reference.
class ReferenceProbe : public ProbeObserver {
 public:
  using ProbeObserver::ProbeObserver;

  /// The values at a time, interpolated linearly. After the last time they are those at the end.
  /// There must be values.
  Vector at(double time) const;
  bool has_values() const { return !times_.empty(); }
  /// The largest magnitude of the values.
  double largest() const { return largest_; }
  /// The largest magnitude of the difference from `other` at the times of this one. Both have values.
  double largest_difference(const ReferenceProbe& other) const;
  /// An estimate of the error of at() between the times: the largest second difference of the values,
  /// |s₀ − 2 s₁ + s₂|/8.
  double interpolation_error() const;
  /// Takes this + share·(this − coarser). The difference is computed at the times of `coarser` and
  /// interpolated linearly between them: it is far smaller than the values.
  void extrapolate(double share, const ReferenceProbe& coarser);

 protected:
  void take(double time, const Vector& values) override;

 private:
  std::vector<double> times_;
  std::vector<Vector> values_;
  double largest_ = 0.0;
};

/// Finds the largest difference of a probe from a reference that has been computed before.
class ProbeDifference : public ProbeObserver {
 public:
  ProbeDifference(std::string name, const ReferenceProbe& reference)
      : ProbeObserver(std::move(name)), reference_(reference) {}

  double largest() const { return largest_; }

 protected:
  void take(double time, const Vector& values) override;

 private:
  const ReferenceProbe& reference_;
  double largest_ = 0.0;
};

}  // namespace tetraction
