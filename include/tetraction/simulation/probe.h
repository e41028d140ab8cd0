// Probes: quantities of a run at chosen vertices, points or tetrahedra, one value or a few for each
// step.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The columns of one probe.
struct ProbeColumns {
  std::string name;  ///< of the probe
  ProbeQuantity quantity;
  std::size_t first = 0;             ///< index of its first value among the values of all probes
  std::vector<std::string> columns;  ///< "tip_x", "tip_y", "tip_z"; one for each value
  int every = 1;                     ///< its values belong to each so many steps

  std::size_t size() const { return columns.size(); }
};

/// Computes the values of probes. Whatever depends on the mesh only is computed once.
///
/// The values of a probe on a selection of N vertices are
///
/// - displacement, position, velocity: the mean (1/N) Σ q_i − X_i, (1/N) Σ q_i, (1/N) Σ v_i. The
///   velocities are those of State::velocity, the mean ones of the last step;
/// - momentum, force, reaction: the sums Σ p_i, Σ f_i, Σ r_i of momenta, of user forces
///   (Session::external_force()) and of the reactions of constraints in the last step;
/// - cauchy_stress, von_mises, jacobian: the mean Σ V_e σ_e / Σ V_e over the tetrahedra that the
///   selection selects (select_tetrahedra()), with their rest volumes V_e.
///
/// A probe of an obstacle has its force on the body, or the moment of that force about a point, as the mean over the
/// last step (Session::obstacle_forces()).
///
/// A probe at a point has the values of the tetrahedron that contains the point in the rest
/// configuration. Displacement, position and velocity are interpolated there linearly.
class ProbeSet {
 public:
  /// Throws InputError for a selection that selects nothing, a point that is not in the body (with
  /// its distance from the nearest tetrahedron), names that occur twice or are no names, a quantity that a point cannot
  /// have, and an obstacle where the system has no contact; one that is not there has no force. `system` must live longer.
  ProbeSet(const std::vector<ProbeSettings>& probes, const MechanicalSystem& system);
  ~ProbeSet();
  ProbeSet(const ProbeSet&) = delete;
  ProbeSet& operator=(const ProbeSet&) = delete;

  /// One entry for each probe, in the order of the settings.
  const std::vector<ProbeColumns>& probes() const;
  /// Number of values of all probes.
  std::size_t value_count() const;
  /// Whether the probe has values at a step: at each multiple of its `every`.
  bool is_due(std::size_t probe, Index step) const;
  /// Writes the values of one probe, or of all, at the session's present state. `values` has room
  /// for value_count() numbers; those of the probe begin at probes()[probe].first. Nothing is
  /// allocated, and sums have a fixed order. The session's body must be the `system` of the
  /// constructor. The stress needs a state at which W is defined.
  void evaluate(std::size_t probe, const Session& session, double* values) const;
  void evaluate(const Session& session, double* values) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The statistics of one column in the summary.
struct ProbeStatistics {
  double min = 0.0, min_time = 0.0;  ///< least value, and the first time that has it, s
  double max = 0.0, max_time = 0.0;
  double last = 0.0;  ///< at the last time
  /// Frequency of the largest part of the spectrum, Hz; NaN without one, see dominant_frequency().
  double frequency = 0.0;
};

/// The values of one probe over time. `values` has probe.size() numbers for each time.
struct ProbeTrace {
  std::vector<double> times;  ///< s
  std::vector<double> values;
};

/// Stores the values of probes while a run is made. Memory is bounded: a trace has 2²⁰ times at most,
/// and all traces together have 2²⁵ numbers at most. If a trace becomes longer, neighbouring values
/// are replaced by their means, as are their times. Extremes and last values are always those of all
/// values.
class ProbeTraces {
 public:
  /// Reserves memory for that many steps.
  ProbeTraces(const ProbeSet& probes, Index step_count);

  /// Stores the values of a step, of the probes that are due, or of all if `all`. `values` are those
  /// of ProbeSet::evaluate(). Nothing is allocated up to the number of steps of the constructor.
  void add(Index step, double time, const double* values, bool all = false);
  const ProbeTrace& trace(std::size_t probe) const { return traces_[probe]; }
  /// One entry for each value of ProbeSet::evaluate(). Entries of probes without values are NaN.
  std::vector<ProbeStatistics> statistics() const;

 private:
  struct Filling {
    std::size_t capacity = 0;  ///< most times
    Index merged = 1;          ///< number of steps whose mean an entry is
    Index pending = 0;         ///< number of steps in the last entry, which is not complete yet
  };
  void add_to_trace(std::size_t probe, double time, const double* values);

  const ProbeSet& probes_;
  std::vector<ProbeTrace> traces_;
  std::vector<Filling> fillings_;
  std::vector<ProbeStatistics> extremes_;  // of all values, without frequencies
};

/// The frequency, Hz, at which a + b cos 2πft + c sin 2πft fits the values best in the sense of
/// least squares. The weights are the Hann window over the time, multiplied by the spacing of the
/// times (the generalised Lomb–Scargle periodogram of Zechmeister and Kürster 2009 with these
/// weights). Times ascend and need not be uniform. Frequencies up to half the mean sampling rate are considered. Returns NaN if the best
/// one has fewer than two periods in the time, and for values that are constant up to `round_off`.
double dominant_frequency(const std::vector<double>& times, const std::vector<double>& values,
                          double round_off = 0.0);

}  // namespace tetraction
