#include "volumetric_instability.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace tetraction {
namespace {

// No body is meant to be stretched beyond these in all directions.
constexpr double kLargestStretch = 10.0;
constexpr double kSmallestStretch = 0.5;

bool is_logarithmic(const LawWithVolumetricPart& law) {
  return law.part == VolumetricPart::kLogarithmic;
}

// ⅓ dΨ/ds at F = s I.
double slope(const LawWithVolumetricPart& law, double s) {
  const double cube = s * s * s;
  const double volumetric = is_logarithmic(law) ? 3.0 * std::log(s) / s : s * s * (cube - 1.0);
  return law.mu1 * (s - 1.0 / s) + 2.0 * law.mu2 * (cube - 1.0 / s) + law.lambda * volumetric;
}

// The s at which Ψ(s I) is largest if λ < 0: above 1 for the quadratic part, below 1 for the
// logarithmic one. Nothing if there is none up to the limits above.
std::optional<double> largest_energy(const LawWithVolumetricPart& law) {
  const auto rises = [&](double s) { return slope(law, s) * (s - 1.0) > 0.0; };
  double stable = 1.0;
  double unstable = is_logarithmic(law) ? kSmallestStretch : kLargestStretch;
  if (!(law.lambda < 0.0) || rises(unstable)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(stable * unstable);
    (rises(middle) ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace

std::string volumetric_instability(const char* model, const LawWithVolumetricPart& law) {
  const std::optional<double> stretch = largest_energy(law);
  if (!stretch) return {};
  LawWithVolumetricPart other = law;
  other.part = is_logarithmic(law) ? VolumetricPart::kQuadratic : VolumetricPart::kLogarithmic;
  return fmt::format(
      "the {} material has a negative lambda = {:.4g} Pa and volumetric = \"{}\": its energy has "
      "no lower bound. A part of the body that is {} {:.3g} times its size in all directions {}. "
      "Take {}parameters with lambda >= 0, such as a larger Poisson's ratio.",
      model, law.lambda, to_string(law.part),
      is_logarithmic(law) ? "compressed below" : "stretched beyond", *stretch,
      is_logarithmic(law) ? "collapses" : "expands without end",
      largest_energy(other) ? "" : fmt::format("volumetric = \"{}\", or ", to_string(other.part)));
}

}  // namespace tetraction
