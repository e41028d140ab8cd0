// The volumetric part U(J) of a material.
#pragma once

#include <cmath>
#include <concepts>

namespace tetraction {

/// The volumetric part of a law, a function of J alone.
enum class VolumetricPart {
  kLogarithmic,  ///< λ/2 (ln J)²
  kQuadratic     ///< λ/2 (J − 1)²
};
/// "log" or "quadratic".
const char* to_string(VolumetricPart part);

/// U as a function of x = J − 1, which keeps its digits near J = 1.
struct VolumetricLaw {
  double modulus = 0.0;      ///< λ or κ, Pa
  bool logarithmic = false;  ///< U = ½ modulus (ln J)², otherwise ½ modulus (J − 1)²

  double energy(double x) const {
    const double y = logarithmic ? std::log1p(x) : x;
    return 0.5 * modulus * y * y;
  }
  double first(double x) const {
    double derivative = 0.0;
    energy_and_first(x, derivative);
    return derivative;
  }
  /// Both of them with one logarithm.
  double energy_and_first(double x, double& derivative) const {
    const double y = logarithmic ? std::log1p(x) : x;
    derivative = modulus * (logarithmic ? y / (1.0 + x) : y);
    return 0.5 * modulus * y * y;
  }
  double second(double x) const {
    const double j = 1.0 + x;
    return logarithmic ? modulus * (1.0 - std::log1p(x)) / (j * j) : modulus;
  }
  /// (U(J + d) − U(J))/d for J = 1 + x, without cancellation.
  double secant(double x, double d) const {
    if (!logarithmic) return modulus * (x + 0.5 * d);
    const double j = 1.0 + x;
    const double r = d / j;
    const double change = std::log1p(r);  // of ln J
    return modulus * (std::log1p(x) + 0.5 * change) * (r == 0.0 ? 1.0 : change / r) / j;
  }
  /// Nearly the derivative of the secant with respect to d, for Newton's method.
  double secant_derivative(double x, double d) const { return 0.5 * second(x + 2.0 / 3.0 * d); }
};

/// A material with the energy Ψ = Ψ₀(F) + U(J), as nodal volumes need it: volumetric_law() returns U, and
/// without_volumetric_part() the material with the energy Ψ₀.
template <class M>
concept HasVolumetricLaw = requires(const M& m) {
  { m.volumetric_law() } -> std::same_as<VolumetricLaw>;
  { m.without_volumetric_part() } -> std::same_as<M>;
};

}  // namespace tetraction
