// The energy of a contact layer.
#pragma once

#include <cmath>
#include <limits>

namespace tetraction {

/// The potential of a contact layer, per area, as a function of the distance d between two surfaces:
/// the logarithmic barrier of Li et al. (2020) in the form per area of Li et al. (2023). With
/// r = d/d̂ and the pressure κ,
///
///     U(d) = −κ d̂ (r − 1)² ln r  for 0 < r < 1,   0 for r ≥ 1,   ∞ for r ≤ 0.
///
/// −U′ is the contact pressure. U has two continuous derivatives at r = 1.
struct Barrier {
  double thickness = 0.0;  ///< d̂, m
  double stiffness = 0.0;  ///< κ, Pa

  /// U, J/m².
  double value(double d) const {
    const double r = d / thickness;
    if (!(r > 0.0)) return std::numeric_limits<double>::infinity();
    if (r >= 1.0) return 0.0;
    return -stiffness * thickness * (r - 1.0) * (r - 1.0) * log_of(r);
  }
  /// U′, Pa; zero or negative. d must be positive.
  double slope(double d) const {
    const double r = d / thickness;
    if (r >= 1.0) return 0.0;
    const double s = r - 1.0;
    return -stiffness * (2.0 * s * log_of(r) + s * s / r);
  }
  /// U″, Pa/m; zero or positive. d must be positive.
  double curvature(double d) const {
    const double r = d / thickness;
    if (r >= 1.0) return 0.0;
    const double s = r - 1.0;
    return -stiffness / thickness * (2.0 * log_of(r) + 4.0 * s / r - s * s / (r * r));
  }
  /// (U(b) − U(a))/(b − a), Pa, without cancellation where both are close; U′ where they are equal.
  /// a and b must be positive.
  double mean_slope(double a, double b) const;
  /// The derivative of mean_slope(a, b) with respect to b, Pa/m; zero or positive.
  double mean_slope_rate(double a, double b) const;
  /// The distance at which U has this value, J/m², or the pressure −U′ has this one, Pa, both zero or more: at
  /// most d̂, with a relative error of 1e-7.
  double distance_at_energy(double energy) const;
  double distance_at_pressure(double pressure) const;

 private:
  static double log_of(double r) { return r > 0.5 ? std::log1p(r - 1.0) : std::log(r); }
};

}  // namespace tetraction
