#include "tetraction/material/yeoh.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The stretch s ≥ 1 of incompressible uniaxial tension with s² + 2/s − 3 = x: the largest root of
// s³ − (3 + x) s + 2 = 0.
double uniaxial_stretch(double x) {
  const double third = 1.0 + x / 3.0;
  return 2.0 * std::sqrt(third) * std::cos(std::acos(-std::pow(third, -1.5)) / 3.0);
}

}  // namespace

Yeoh::Yeoh(double c10, double c20, double c30, double kappa) : parameters_{c10, c20, c30, kappa} {
  if (!std::isfinite(c10) || !(c10 > 0.0)) {
    throw InputError(fmt::format(
        "yeoh: c10 = {} Pa must be positive and finite; it is half the shear modulus.", c10));
  }
  if (!std::isfinite(c20) || !std::isfinite(c30)) {
    throw InputError(fmt::format("yeoh: c20 = {} Pa and c30 = {} Pa must be finite.", c20, c30));
  }
  if (!std::isfinite(kappa) || !(kappa >= 0.0)) {
    throw InputError(fmt::format("yeoh: kappa = {} Pa must not be negative or infinite.", kappa));
  }
}

Yeoh Yeoh::from_young(const LameParameters& lame, double c20, double c30) {
  return {0.5 * lame.mu, c20, c30, lame.lambda + 2.0 / 3.0 * lame.mu};
}

double Yeoh::unstable_from() const {
  const auto& [c10, c20, c30, kappa] = parameters_;
  const double discriminant = c20 * c20 - 3.0 * c10 * c30;
  if ((c20 >= 0.0 && c30 >= 0.0) || discriminant < 0.0) {
    return std::numeric_limits<double>::infinity();
  }
  // The least positive root, in the form in which nothing cancels. The first one holds for C₃₀ = 0,
  // too.
  const double root = std::sqrt(discriminant);
  return c20 < 0.0 ? c10 / (root - c20) : (root + c20) / (-3.0 * c30);
}

std::string Yeoh::instability() const {
  const double x = unstable_from();
  if (!std::isfinite(x)) return {};
  return fmt::format(
      "the yeoh material with c10 = {:.4g}, c20 = {:.4g} and c30 = {:.4g} Pa is unstable: at a "
      "stretch of {:.3g} in uniaxial tension its stress has fallen to zero (c10 + 2 c20 x + 3 "
      "c30 x^2 = 0 with x = I1bar - 3 = {:.3g}), and further strain sets energy free. Keep the "
      "strains well below that, or take parameters that are stable everywhere: c20 and c30 of 0 "
      "or more, or c20^2 < 3 c10 c30.",
      c10(), c20(), c30(), uniaxial_stretch(x), x);
}

}  // namespace tetraction
