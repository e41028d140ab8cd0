#include "tetraction/dynamics/terms/rayleigh_damping.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

double angular_frequency(double frequency) {
  return 2.0 * std::numbers::pi * frequency;
}

// `difference` = x − y, without the round-off of a difference of equal numbers.
double difference(double x, double y) {
  constexpr double kEqual = 1e-14;
  return std::abs(x - y) <= kEqual * std::max(x, y) ? 0.0 : x - y;
}

}  // namespace

Damping rayleigh_damping(const DampingRatio& ratio, const LameParameters& lame) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (!(ratio.frequency[i] > 0.0) || !std::isfinite(ratio.frequency[i])) {
      throw InputError(
          fmt::format("has the frequency {} Hz; frequencies must be above 0.", ratio.frequency[i]));
    }
    if (!(ratio.value[i] >= 0.0) || !std::isfinite(ratio.value[i])) {
      throw InputError(fmt::format(
          "has the value {}; damping ratios must be 0 or more: negative damping makes energy.",
          ratio.value[i]));
    }
  }
  const std::size_t low = ratio.frequency[0] < ratio.frequency[1] ? 0 : 1;
  const double w1 = angular_frequency(ratio.frequency[low]);
  const double w2 = angular_frequency(ratio.frequency[1 - low]);
  const double z1 = ratio.value[low];
  const double z2 = ratio.value[1 - low];
  if (w1 == w2) {
    throw InputError(
        fmt::format("has the frequency {} Hz twice; give two different ones.", ratio.frequency[0]));
  }
  const double span = (w2 - w1) * (w2 + w1);
  const double a = 2.0 * w1 * w2 * difference(z1 * w2, z2 * w1) / span;
  const double beta = 2.0 * difference(z2 * w2, z1 * w1) / span;
  if (a < 0.0 || beta < 0.0) {
    throw InputError(fmt::format(
        "cannot be had: these values need a negative {}. Mass damping gives ratios that fall as "
        "1/f, viscosity gives ratios that rise as f, and a sum of both is between them: with {} at "
        "{} Hz, the value at {} Hz must be from {:.6g} to {:.6g}.",
        a < 0.0 ? "mass_damping" : "viscosity", z1, ratio.frequency[low], ratio.frequency[1 - low],
        z1 * w1 / w2, z1 * w2 / w1));
  }
  Damping damping;
  damping.mass_damping = a;
  damping.viscosity = beta * lame.mu;
  return damping;
}

double viscous_time(DeformationKind kind, double viscosity, const LameParameters& lame) {
  const double mu = lame.mu;
  const double kappa = lame.lambda + 2.0 / 3.0 * mu;
  const double nu = lame.lambda / (2.0 * (lame.lambda + mu));
  if (viscosity == 0.0) return 0.0;
  switch (kind) {
    case DeformationKind::kShear:
      return viscosity / mu;
    case DeformationKind::kBending:
      return viscosity * (1.0 + 2.0 * nu * nu) / (mu * (1.0 + nu));
    case DeformationKind::kVolumeChange:
      break;
  }
  return kappa > 0.0 ? 2.0 / 3.0 * viscosity / kappa : std::numeric_limits<double>::infinity();
}

double damping_ratio(DeformationKind kind, const Damping& damping, const LameParameters& lame,
                     double frequency) {
  const double omega = angular_frequency(frequency);
  return damping.mass_damping / (2.0 * omega) +
         0.5 * omega * viscous_time(kind, damping.viscosity, lame);
}

}  // namespace tetraction
