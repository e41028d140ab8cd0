#include "reference_extrapolation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "series_errors.h"

namespace tetraction {
namespace {

constexpr double kNoOrder = std::numeric_limits<double>::quiet_NaN();

// An observed order that differs by more from the theoretical one does not allow the extrapolation.
constexpr double kOrderTolerance = 0.4;

// Differences between the runs A, B and C with 2h, h and h/2 and their extrapolations.
struct Differences {
  double coarse = 0.0;        // |A − B|
  double fine = 0.0;          // |B − C|
  double extrapolated = 0.0;  // |E(h) − E(2h)|

  double order() const { return fine > 0.0 && coarse > 0.0 ? std::log2(coarse / fine) : kNoOrder; }
};

// E(h) − E(2h) with E(h) = C + share (C − B) and E(2h) = B + share (B − A).
Differences differences_of(const Vector& a, const Vector& b, const Vector& c, double share) {
  return {(a - b).norm(), (b - c).norm(), ((1.0 + share) * (c - b) - share * (b - a)).norm()};
}

// Root mean squares over the times of the tracks.
Differences differences_over_time(const std::array<const MotionTrack*, 3>& tracks, double share) {
  Differences sums;
  const std::size_t count = tracks[2]->count;
  for (std::size_t k = 0; k < count; ++k) {
    const Differences d = differences_of(tracks[0]->positions[k], tracks[1]->positions[k],
                                         tracks[2]->positions[k], share);
    sums.coarse += d.coarse * d.coarse;
    sums.fine += d.fine * d.fine;
    sums.extrapolated += d.extrapolated * d.extrapolated;
  }
  const auto mean = [&](double sum) { return std::sqrt(sum / static_cast<double>(count)); };
  return {mean(sums.coarse), mean(sums.fine), mean(sums.extrapolated)};
}

// The largest differences of the error probe.
Differences differences_of_probes(const std::array<const ProbeRecord*, 3>& records, double share) {
  const ProbeRecord& a = *records[0];
  const ProbeRecord& b = *records[1];
  const ProbeRecord& c = *records[2];
  ProbeRecord best = c;
  best.extrapolate(share, b);
  ProbeRecord coarser = b;
  coarser.extrapolate(share, a);
  return {a.largest_difference(b), b.largest_difference(c), coarser.largest_difference(best)};
}

// What differences say of the theoretical order.
enum class Order { kShown, kHidden, kMissed };

// Differences that may be wrong by `inexact` show the order, hide it, or speak against it.
Order judged(const Differences& found, int theory, double inexact) {
  const double order = found.order();
  if (std::abs(order - theory) <= kOrderTolerance) return Order::kShown;
  // The orders that are possible lie between these two.
  const double fine = std::max(0.0, found.fine - inexact);
  const double coarse = std::max(0.0, found.coarse - inexact);
  const bool may_be_larger = found.coarse + inexact >= std::exp2(theory - kOrderTolerance) * fine;
  const bool may_be_smaller =
      coarse <= std::exp2(theory + kOrderTolerance) * (found.fine + inexact);
  return may_be_larger && may_be_smaller ? Order::kHidden : Order::kMissed;
}

// One of the quantities that are extrapolated.
struct JudgedQuantity {
  Differences differences;
  const char* place = "";  // of the order in messages
  Order order = Order::kShown;

  // "the observed order at the end is 1.20", if the differences speak against the order.
  std::string miss() const {
    if (order != Order::kMissed) return {};
    const double found = differences.order();
    return fmt::format("the observed order {} is {}", place,
                       std::isfinite(found) ? fmt::format("{:.2f}", found) : "not defined");
  }
};

}  // namespace

Inexactness inexactness(const StudyRow& row) {
  const double residuals = row.angular_momentum_drift_allowed;
  return {residuals > 0.0 ? residuals : 0.0,
          std::numeric_limits<double>::epsilon() * (10.0 + static_cast<double>(row.steps))};
}

ExtrapolatedReference extrapolate_reference(
    Integrator integrator, double step, const Inexactness& inexact, const ErrorMeasure& probe,
    const std::array<std::shared_ptr<const MotionTrack>, 3>& tracks) {
  const int p = order(integrator);
  const double share = 1.0 / (std::pow(2.0, p) - 1.0);
  const std::array<const ProbeRecord*, 3> probes{tracks[0]->probe(probe.series()),
                                                 tracks[1]->probe(probe.series()),
                                                 tracks[2]->probe(probe.series())};
  const bool has_probe = probes[2] != nullptr;

  const MotionTrack& finest = *tracks[2];
  const TrackScales finest_scales = scales_of(finest);
  const double finest_probe = has_probe ? series_scale(probe, finest) : 0.0;
  // What is inexact in the motion may be anywhere in it at the end. Positions are rounded, not
  // displacements.
  const double scale = std::max(finest_scales.at_end, finest_scales.over_time);
  const double level =
      (inexact.residuals + inexact.round_off) * scale + inexact.round_off * finest.last().norm();
  const auto quantity = [p](const Differences& differences, const char* place, double level_of) {
    return JudgedQuantity{differences, place, judged(differences, p, level_of)};
  };
  const JudgedQuantity end =
      quantity(differences_of(tracks[0]->last(), tracks[1]->last(), finest.last(), share),
               "at the end", level);
  const JudgedQuantity time =
      quantity(differences_over_time({tracks[0].get(), tracks[1].get(), &finest}, share),
               "over time", level);
  const JudgedQuantity of_probe = has_probe ? quantity(differences_of_probes(probes, share),
                                                       "of the probe", level / scale * finest_probe)
                                            : JudgedQuantity{};

  ExtrapolatedReference made;
  ReferenceExtrapolation& result = made.result;
  result.step = step;
  result.order_at_end = end.differences.order();
  result.order_over_time = time.differences.order();
  if (has_probe) result.order_of_probe = of_probe.differences.order();
  result.is_exact = end.order == Order::kHidden && time.order == Order::kHidden;
  result.probe_is_exact = of_probe.order == Order::kHidden;
  // `unit` makes the differences relative.
  const auto reason = [p](const std::string& misses, bool is_exact, const Differences& found,
                          double unit) {
    if (!misses.empty()) return fmt::format("{}, while the theoretical order is {}", misses, p);
    if (!is_exact) return std::string();
    return fmt::format(
        "the runs differ by {:.1e} and {:.1e} only, which the tolerance of the solver and "
        "round-off explain, so that the differences show no order",
        found.coarse / unit, found.fine / unit);
  };
  const std::string at_end = end.miss();
  const std::string over_time = time.miss();
  const bool both = !at_end.empty() && !over_time.empty();
  result.reason = reason(at_end + (both ? ", and " : "") + over_time, result.is_exact,
                         time.differences, finest_scales.over_time);
  result.is_valid = result.reason.empty();
  result.probe_reason = reason(of_probe.miss(), result.probe_is_exact, of_probe.differences,
                               finest_probe > 0.0 ? finest_probe : 1.0);
  result.probe_is_valid = result.probe_reason.empty();

  made.motion = tracks[2];
  if (result.is_valid || (has_probe && result.probe_is_valid)) {
    auto best = std::make_shared<MotionTrack>(finest);
    if (result.is_valid) best->extrapolate(share, *tracks[1]);
    if (has_probe && result.probe_is_valid) {
      const auto place = static_cast<std::size_t>(probes[2] - finest.probes.data());
      best->probes[place].extrapolate(share, *probes[1]);
    }
    made.motion = std::move(best);
  }

  // The leading term of the extrapolation is at least of order p + 1.
  const double next = 1.0 / (std::pow(2.0, p + 1) - 1.0);
  const auto error_of = [&](const Differences& d, bool is_valid, bool is_exact, double unit) {
    if (!(unit > 0.0)) return kNoOrder;
    return (is_valid ? next * d.extrapolated : (is_exact ? 1.0 : share) * d.fine) / unit;
  };
  const TrackScales scales = scales_of(*made.motion);
  result.error_at_end = error_of(end.differences, result.is_valid, result.is_exact, scales.at_end);
  result.error_over_time =
      error_of(time.differences, result.is_valid, result.is_exact, scales.over_time);
  if (has_probe) {
    result.error_of_probe = error_of(of_probe.differences, result.probe_is_valid,
                                     result.probe_is_exact, series_scale(probe, *made.motion));
  }
  if (result.is_valid) {
    result.finest_error_at_end = (finest.last() - made.motion->last()).norm() / scales.at_end;
  }
  return made;
}

}  // namespace tetraction
