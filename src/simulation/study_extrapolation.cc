#include "study_extrapolation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace tetraction {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// An observed order that differs by more from the theoretical one does not allow the extrapolation.
constexpr double kOrderTolerance = 0.4;

// Differences between the runs A, B and C with 2h, h and h/2 and their extrapolations.
struct Differences {
  double coarse = 0.0;        // |A − B|
  double fine = 0.0;          // |B − C|
  double extrapolated = 0.0;  // |E(h) − E(2h)|

  double order() const { return fine > 0.0 && coarse > 0.0 ? std::log2(coarse / fine) : kNone; }
};

// E(h) − E(2h) with E(h) = C + share (C − B) and E(2h) = B + share (B − A).
Differences differences_of(const Vector& a, const Vector& b, const Vector& c, double share) {
  return {(a - b).norm(), (b - c).norm(), ((1.0 + share) * (c - b) - share * (b - a)).norm()};
}

// Root mean squares over the times of the tracks.
Differences differences_over_time(const std::array<ReferenceRecord*, 3>& records, double share) {
  Differences sums;
  const std::size_t count = records[2]->track.sample_count();
  for (std::size_t i = 0; i < count; ++i) {
    const Differences d = differences_of(records[0]->track.sample(i), records[1]->track.sample(i),
                                         records[2]->track.sample(i), share);
    sums.coarse += d.coarse * d.coarse;
    sums.fine += d.fine * d.fine;
    sums.extrapolated += d.extrapolated * d.extrapolated;
  }
  const auto mean = [&](double sum) { return std::sqrt(sum / static_cast<double>(count)); };
  return {mean(sums.coarse), mean(sums.fine), mean(sums.extrapolated)};
}

// The largest differences of the error probe.
Differences differences_of_probes(const std::array<ReferenceRecord*, 3>& records, double share) {
  const ReferenceProbe& a = records[0]->probe;
  const ReferenceProbe& b = records[1]->probe;
  const ReferenceProbe& c = records[2]->probe;
  ReferenceProbe best = c;
  best.extrapolate(share, b);
  ReferenceProbe coarser = b;
  coarser.extrapolate(share, a);
  return {a.largest_difference(b), b.largest_difference(c), coarser.largest_difference(best)};
}

// Why the runs cannot be extrapolated, or an empty text.
std::string misfit(const ReferenceExtrapolation& found, bool has_probe, int theory) {
  std::string text;
  const auto check = [&](double order, const char* what) {
    if (std::abs(order - theory) <= kOrderTolerance) return;
    text += fmt::format("{}the observed order {} is {}", text.empty() ? "" : ", and ", what,
                        std::isfinite(order) ? fmt::format("{:.2f}", order) : "not defined");
  };
  check(found.order_at_end, "at the end");
  check(found.order_over_time, "over time");
  if (has_probe) check(found.order_of_probe, "of the probe");
  return text.empty() ? text : fmt::format("{}, while the theoretical order is {}", text, theory);
}

}  // namespace

ReferenceDistance distance_between(const ReferenceRecord& run, const ReferenceRecord& reference) {
  ReferenceDistance distance;
  distance.at_end = (run.track.last() - reference.track.last()).norm();
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < run.track.sample_count(); ++i) {
    if (!run.track.is_step(i)) continue;
    squares += (run.track.sample(i) - reference.track.sample(i)).squaredNorm();
    count += 1.0;
  }
  distance.over_time = count > 0.0 ? std::sqrt(squares / count) : kNone;
  if (run.probe.has_values()) distance.of_probe = run.probe.largest_difference(reference.probe);
  return distance;
}

ExtrapolatedReference extrapolate_reference(Integrator integrator, double step,
                                            std::array<ReferenceRecord*, 3> records) {
  const int p = order(integrator);
  const double share = 1.0 / (std::pow(2.0, p) - 1.0);
  const bool has_probe = records[2]->probe.has_values();

  const Differences at_end = differences_of(records[0]->track.last(), records[1]->track.last(),
                                            records[2]->track.last(), share);
  const Differences over_time = differences_over_time(records, share);
  const Differences of_probe = has_probe ? differences_of_probes(records, share) : Differences{};

  ExtrapolatedReference made;
  ReferenceExtrapolation& result = made.result;
  result.step = step;
  result.order_at_end = at_end.order();
  result.order_over_time = over_time.order();
  if (has_probe) result.order_of_probe = of_probe.order();
  result.reason = misfit(result, has_probe, p);
  result.is_valid = result.reason.empty();

  ReferenceRecord& finest = *records[2];
  if (result.is_valid) {
    ReferenceRecord best = finest;
    best.track.combine(1.0 + share, records[1]->track);
    if (has_probe) best.probe.extrapolate(share, records[1]->probe);
    made.distances[2] = distance_between(finest, best);
    finest = std::move(best);
  }
  for (std::size_t run = 0; run < 2; ++run) {
    made.distances[run] = distance_between(*records[run], finest);
  }

  // The leading term of the extrapolation is at least of order p + 1.
  const double next = 1.0 / (std::pow(2.0, p + 1) - 1.0);
  const auto error_of = [&](const Differences& d, double scale) {
    if (!(scale > 0.0)) return kNone;
    return (result.is_valid ? next * d.extrapolated : share * d.fine) / scale;
  };
  const double scale_at_end = finest.track.scale_at_end();
  result.error_at_end = error_of(at_end, scale_at_end);
  result.error_over_time = error_of(over_time, finest.track.scale_over_time());
  if (has_probe) result.error_of_probe = error_of(of_probe, finest.probe.largest());
  if (result.is_valid) result.finest_error_at_end = made.distances[2].at_end / scale_at_end;
  return made;
}

}  // namespace tetraction
