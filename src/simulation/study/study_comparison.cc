// Compares the runs of a study with their references.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "reference_extrapolation.h"
#include "run_scene.h"
#include "series_errors.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// An error below this many times the reference's own error gives no order.
constexpr double kAboveReference = 5.0;

using Track = std::shared_ptr<const MotionTrack>;
using Rows = std::vector<std::optional<StudyRow>>;

// A reference with its motion, which is null if it did not reach the end.
struct Reference {
  RunStatus status = RunStatus::kCancelled;
  std::string message;
  Track motion;
  std::optional<ReferenceExtrapolation> extrapolation;
  TrackScales scales;
};

// Two neighbouring steps of a rule, with the error of the finer one and the difference of the two runs.
struct Neighbours {
  const StudyRow* finer = nullptr;
  const StudyRow* coarser = nullptr;
  double error = std::numeric_limits<double>::infinity();
  double difference = 0.0;
};

double root_mean_square_distance(const MotionTrack& a, const MotionTrack& b) {
  double squares = 0.0;
  for (std::size_t k = 0; k < a.count; ++k) {
    squares += (a.positions[k] - b.positions[k]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(a.count));
}

// Whether all of these steps are multiples of the step of the reference.
bool are_multiples(const std::vector<PlannedRun>& runs, double reference) {
  return std::all_of(runs.begin(), runs.end(), [&](const PlannedRun& run) {
    const double ratio = run.step / reference;
    return std::abs(ratio - std::round(ratio)) <= 1e-9 * ratio && ratio > 0.5;
  });
}

class Comparison {
 public:
  Comparison(const StudyPlan& plan, const Rows& rows, const TrackSource& tracks)
      : plan_(plan), rows_(rows), tracks_(tracks) {}

  StudyResult result() {
    begin();
    Reference first;
    for (std::size_t i = 0; i < plan_.references.size(); ++i) {
      Reference reference = make_reference(plan_.references[i]);
      add_reference(i, reference, first);
      const Neighbours closest = compare_with(i, reference);
      set_orders(i, reference, closest);
      if (i == 0) first = std::move(reference);
    }
    if (result_.is_interrupted) {
      result_.remarks.emplace_back("the study was interrupted: the runs from there on are missing");
    }
    if (result_.left_out > 0) {
      result_.remarks.push_back(
          fmt::format("this is a part of a study, with {} of its {} runs: tetraction study merge "
                      "joins the parts",
                      rows_.size() - result_.left_out, rows_.size()));
    }
    for (std::optional<StudyRow>& row : rows_) {
      if (row) result_.rows.push_back(std::move(*row));
    }
    const VariantReference& leading = result_.references.front();
    result_.reference_status = leading.status;
    result_.reference_directory = leading.directory;
    result_.reference_error = leading.error;
    result_.extrapolation = leading.extrapolation;
    if (result_.references.size() < 2) result_.references.clear();
    return std::move(result_);
  }

 private:
  bool has_probe() const { return !plan_.error_probe.empty(); }
  // How the error probe of a motion differs from that of another one; NaN without a probe.
  double probe_difference(const MotionTrack& motion, const MotionTrack& exact) const {
    return has_probe() ? series_error(plan_.error_series(), motion, exact) : kNone;
  }
  // The error that orders are computed from.
  double error_of(const StudyRow& row) const {
    return has_probe() ? row.probe_error : row.position_error;
  }

  void begin() {
    result_.stable_step = plan_.stable_step;
    result_.end = plan_.end;
    const PlannedRun& finest = plan_.finest_run(plan_.references.front());
    result_.reference_integrator = finest.integrator;
    result_.reference_step = finest.step;
    result_.error_probe = plan_.error_probe;
    result_.error_kind = plan_.error_kind;
    result_.probes = plan_.probes;
    for (const StudyVariant& variant : plan_.variants) {
      if (!variant.name.empty()) result_.variants.push_back({variant.name, variant.values});
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      std::optional<StudyRow>& row = rows_[i];
      const bool is_left_out = !row && plan_.runs[i].is_left_out;
      result_.left_out += is_left_out ? 1U : 0U;
      if (is_left_out) continue;
      if (!row || row->status == RunStatus::kCancelled) result_.is_interrupted = true;
      if (!row) continue;
      row->position_error = row->position_error_rms = row->probe_error = kNone;
      row->observed_order = row->probe_value = kNone;
      row->is_reference = false;
    }
  }

  // The track of a run that reached the end, or null.
  Track track_of(std::size_t run) const {
    if (!rows_[run] || rows_[run]->status != RunStatus::kFinished) return nullptr;
    Track track = tracks_(plan_.runs[run]);
    return track && track->is_whole() ? track : nullptr;
  }

  Reference make_reference(const PlannedReference& planned) {
    Reference reference;
    std::optional<StudyRow>& finest = rows_[planned.runs.back()];
    if (!finest) return reference;
    reference.status = finest->status;
    reference.message = finest->message;
    reference.motion = track_of(planned.runs.back());
    if (planned.runs.size() == 3) extrapolate(planned, reference);
    if (!reference.motion) return reference;
    reference.scales = scales_of(*reference.motion);
    const auto& found = reference.extrapolation;
    finest->is_reference = !(found && found->is_valid_for(has_probe()));
    return reference;
  }

  // Extrapolates the three runs of a reference, if all of them were made.
  void extrapolate(const PlannedReference& planned, Reference& reference) const {
    Inexactness inexact;
    std::array<Track, 3> tracks;
    const StudyRow* failed = nullptr;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::optional<StudyRow>& row = rows_[planned.runs[i]];
      if (!row || row->status == RunStatus::kCancelled) return;
      tracks[i] = track_of(planned.runs[i]);
      if (!tracks[i] && failed == nullptr) failed = &*row;
      const Inexactness own = inexactness(*row);
      inexact.residuals = std::max(inexact.residuals, own.residuals);
      inexact.round_off = std::max(inexact.round_off, own.round_off);
    }
    const PlannedRun& middle = plan_.runs[planned.runs[1]];
    if (failed != nullptr) {
      ReferenceExtrapolation found;
      found.step = middle.step;
      found.is_valid = found.probe_is_valid = false;
      found.reason = found.probe_reason =
          fmt::format("the run with a step of {:.4g} s did not reach the end", failed->step);
      reference.extrapolation = found;
      return;
    }
    ExtrapolatedReference made = extrapolate_reference(middle.integrator, middle.step, inexact,
                                                       plan_.error_series(), tracks);
    // Between the steps of the finest run its probe is interpolated.
    const double scale = has_probe() ? series_scale(plan_.error_series(), *made.motion) : 0.0;
    if (scale > 0.0 && !are_multiples(plan_.runs, plan_.finest_run(planned).step)) {
      const ProbeRecord& probe = *made.motion->probe(plan_.error_series().series());
      made.result.error_of_probe += probe.interpolation_error() / scale;
    }
    reference.extrapolation = std::move(made.result);
    reference.motion = std::move(made.motion);
  }

  // Enters a reference in the result.
  void add_reference(std::size_t index, const Reference& reference, const Reference& first) {
    const PlannedReference& planned = plan_.references[index];
    const PlannedRun& finest = plan_.finest_run(planned);
    VariantReference entry;
    entry.variant = plan_.variants[planned.variant].name;
    entry.status = reference.status;
    entry.directory = finest.directory;
    entry.extrapolation = reference.extrapolation;
    if (index > 0) entry.difference = difference_from_first(index, reference, first);
    for (std::size_t i = 0; i < plan_.variants.size(); ++i) {
      if (plan_.reference_of[i] == index) entry.variants.push_back(plan_.variants[i].name);
    }
    const std::string of_variant = name_of(entry.variant);
    if (entry.status != RunStatus::kFinished) {
      if (entry.status != RunStatus::kCancelled) {
        result_.remarks.push_back("the reference run" + of_variant + " did not reach the end (" +
                                  reference.message + "): there are no errors");
      }
    } else if (entry.extrapolation) {
      const ReferenceExtrapolation& found = *entry.extrapolation;
      const auto add = [&](const std::string& what, const std::string& reason) {
        result_.remarks.push_back(fmt::format(
            "the reference{}{} is not extrapolated: {}. It is the run with a step of {:.4g} s.",
            of_variant, what, reason, finest.step));
      };
      if (!found.is_valid) add("", found.reason);
      if (has_probe() && !found.probe_is_valid && found.probe_reason != found.reason) {
        add(plan_.error_kind == ErrorKind::kEnergy ? " of " + plan_.error_probe
                                                   : " of the probe " + plan_.error_probe,
            found.probe_reason);
      }
    }
    if (plan_.error_kind == ErrorKind::kFrequency && reference.motion &&
        !std::isfinite(series_value(plan_.error_series(), *reference.motion, *reference.motion))) {
      result_.remarks.push_back(
          fmt::format("there are no errors of the frequency of the probe {}{}, because it has no "
                      "vibration with at least two periods up to the end at {:.4g} s: make "
                      "time.end longer, or take another --error",
                      plan_.error_probe, of_variant, plan_.end));
    }
    result_.references.push_back(std::move(entry));
  }

  std::string name_of(const std::string& variant) const {
    return plan_.references.size() > 1 ? " of " + variant : std::string();
  }

  // How far a reference is from the first one.
  ReferenceDifference difference_from_first(std::size_t index, const Reference& reference,
                                            const Reference& first) const {
    ReferenceDifference difference;
    if (!first.motion || !reference.motion) return difference;
    difference.probe = probe_difference(*reference.motion, *first.motion);
    if (!plan_.has_first_mesh[index]) return difference;
    difference.position =
        (reference.motion->last() - first.motion->last()).norm() / first.scales.at_end;
    difference.position_rms =
        root_mean_square_distance(*reference.motion, *first.motion) / first.scales.over_time;
    return difference;
  }

  // Sets the errors of all runs that are compared with a reference. Returns the neighbouring steps of which the
  // finer one has the smallest error.
  Neighbours compare_with(std::size_t index, const Reference& reference) {
    Neighbours closest;
    if (!reference.motion) return closest;
    const StudyRow* finer = nullptr;
    Track finer_track;
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) {
      const PlannedRun& run = plan_.runs[i];
      if (plan_.reference_of[run.variant] != index) continue;
      const Track track = track_of(i);
      if (!track) continue;
      StudyRow& row = *rows_[i];
      set_errors(row, *track, reference);
      if (!is_in_sequence(run, index)) continue;
      if (finer != nullptr && is_of_same_rule(*finer, row)) {
        const double error = error_of(*finer);
        if (error > 0.0 && error < closest.error) {
          closest = {finer, &row, error, difference_of(*finer_track, *track, reference)};
        }
      }
      finer = &row;
      finer_track = track;
    }
    return closest;
  }

  // Whether a run is one of the steps of a rule that are compared with each other. A rule that adapts its steps has
  // none.
  bool is_in_sequence(const PlannedRun& run, std::size_t reference) const {
    return run.role == StudyRole::kRun && !run.compares_solver &&
           run.variant == plan_.references[reference].variant &&
           (run.settings.empty() || scene_of(plan_, run).time.adapt == StepAdaptation::kNone);
  }

  static bool is_of_same_rule(const StudyRow& a, const StudyRow& b) {
    return a.integrator == b.integrator && a.settings == b.settings;
  }

  void set_errors(StudyRow& row, const MotionTrack& track, const Reference& reference) const {
    const MotionTrack& exact = *reference.motion;
    row.position_error = (track.last() - exact.last()).norm() / reference.scales.at_end;
    row.position_error_rms = root_mean_square_distance(track, exact) / reference.scales.over_time;
    row.probe_error = probe_difference(track, exact);
    if (has_probe()) row.probe_value = series_value(plan_.error_series(), track, exact);
  }

  // The difference of two runs in the error that orders are computed from.
  double difference_of(const MotionTrack& a, const MotionTrack& b,
                       const Reference& reference) const {
    if (!has_probe()) return (a.last() - b.last()).norm() / reference.scales.at_end;
    return probe_difference(b, a);
  }

  // Computes the error of a reference and the orders between neighbouring steps of its runs.
  void set_orders(std::size_t index, const Reference& reference, const Neighbours& closest) {
    if (!reference.motion) return;
    double reference_error = std::max(0.0, error_of_reference(index, reference));
    if (shows_error_of_reference(index, closest, reference_error)) {
      reference_error = closest.error;
      result_.remarks.push_back(fmt::format(
          "the errors of {0} with steps of {1:.4g} and {2:.4g} s are those of the reference{3}: "
          "these two runs differ from each other by {4:.1e}, and from the reference by {5:.1e}. A "
          "finer reference (--reference-step) shows their own errors.",
          to_string(closest.finer->integrator), closest.finer->step, closest.coarser->step,
          name_of(result_.references[index].variant), closest.difference, closest.error));
    }
    if (reference_error > 0.0) result_.references[index].error = reference_error;
    const bool is_run =
        !reference.extrapolation || !reference.extrapolation->is_valid_for(has_probe());
    const StudyRow* finer = nullptr;
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) {
      if (!rows_[i] || !is_in_sequence(plan_.runs[i], index)) continue;
      StudyRow& row = *rows_[i];
      const StudyRow* before = std::exchange(finer, &row);
      if (before == nullptr || !is_of_same_rule(*before, row) || before->is_reference) continue;
      const bool is_of_family = is_run && row.integrator == result_.reference_integrator;
      if (!is_of_family && error_of(*before) < kAboveReference * reference_error) continue;
      row.observed_order = observed_order(before->step, error_of(*before), row.step, error_of(row),
                                          is_of_family ? result_.reference_step : 0.0);
    }
  }

  // Whether neighbouring steps agree better than they differ from the reference, as they cannot do if their rule is
  // at least of first order and the reference is exact. Large errors may be those of a motion that is lost. Peaks say
  // nothing: the largest samples of two steps may agree by chance.
  bool shows_error_of_reference(std::size_t index, const Neighbours& closest,
                                double known_error) const {
    constexpr double kClear = 0.5;
    constexpr double kLost = 0.1;
    if (closest.finer == nullptr || closest.error > kLost || closest.error < known_error ||
        plan_.error_kind == ErrorKind::kPeak) {
      return false;
    }
    const StudyRow& finest = *rows_[plan_.references[index].runs.back()];
    double inexact = 0.0;
    for (const StudyRow* row : {closest.finer, closest.coarser, &finest}) {
      const Inexactness own = inexactness(*row);
      inexact += own.residuals + own.round_off;
    }
    if (closest.error < 10.0 * inexact) return false;
    const double ratio = closest.coarser->step / closest.finer->step;
    return closest.difference < kClear * closest.error * (ratio - 1.0);
  }

  // The error of the reference itself is estimated from the finest other run of its family and the
  // rule's order p: e(h) = C (h^p − h_r^p), so that C h_r^p = e h_r^p/(h^p − h_r^p). It is zero if
  // there is no such run.
  double error_of_reference(std::size_t index, const Reference& reference) const {
    if (reference.extrapolation) {
      const ReferenceExtrapolation& found = *reference.extrapolation;
      const double error = has_probe() ? found.error_of_probe : found.error_at_end;
      if (std::isfinite(error)) return error;
    }
    const PlannedRun& finest = plan_.finest_run(plan_.references[index]);
    for (std::size_t i = 0; i < plan_.runs.size(); ++i) {
      const PlannedRun& run = plan_.runs[i];
      if (!rows_[i] || run.variant != finest.variant || run.rule() != finest.rule() ||
          run.step <= finest.step || !(error_of(*rows_[i]) > 0.0)) {
        continue;
      }
      const double ratio = std::pow(run.step / finest.step, order(run.integrator));
      return error_of(*rows_[i]) / (ratio - 1.0);
    }
    return 0.0;
  }

  const StudyPlan& plan_;
  Rows rows_;
  const TrackSource& tracks_;
  StudyResult result_;
};

}  // namespace

StudyResult compare_runs(const StudyPlan& plan, const std::vector<std::optional<StudyRow>>& rows,
                         const TrackSource& tracks) {
  return Comparison(plan, rows, tracks).result();
}

double observed_order(double h1, double e1, double h2, double e2, double hr) {
  if (!(e1 > 0.0) || !(e2 > e1) || !(h2 > h1) || !(h1 > hr)) return kNone;
  if (hr == 0.0) return std::log(e2 / e1) / std::log(h2 / h1);
  const double target = std::log(e2 / e1);
  const auto ratio = [&](double p) {
    return std::log((std::pow(h2, p) - std::pow(hr, p)) / (std::pow(h1, p) - std::pow(hr, p)));
  };
  double low = 1e-3;
  double high = 12.0;
  if (ratio(low) > target || ratio(high) < target) return kNone;
  while (high - low > 1e-10) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) < target ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tetraction
