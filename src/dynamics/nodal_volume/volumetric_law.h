// The volumetric part U(J) of a material.
#pragma once

#include <cmath>

#include "tetraction/material/material_field.h"

namespace tetraction {

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

/// The volumetric part of a material. Where parameters vary, its modulus is that of the material's
/// model. Throws InputError for Saint Venant–Kirchhoff and custom materials, whose energy has no part
/// U(J).
VolumetricLaw volumetric_law(const MaterialField& material);
/// The modulus of the volumetric part in element e.
double volumetric_modulus(const MaterialField& material, Index e);
/// The material with λ or κ equal to zero. Throws InputError as volumetric_law() does.
MaterialField without_volumetric_part(const MaterialField& material);

}  // namespace tetraction
