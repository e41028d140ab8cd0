#pragma once

#include <array>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Yeoh (1993): Ψ = Σ_{i=1..3} C_i0 (Ī₁ − 3)^i + κ/2 (J − 1)², Ī₁ = J^{−2/3} I₁. Needs J > 0.
///
/// The first term alone is the neo-Hookean law of most commercial codes. The others describe the
/// softening of filled rubber at moderate stretches (usually C₂₀ < 0) and its stiffening at large
/// ones (C₃₀ > 0). The material is unstable where ∂Ψ/∂Ī₁ is not positive, because further shear
/// releases energy there. Such parameters are accepted; unstable_from() tells where that is.
///
/// The small-strain parameters are μ = 2 C₁₀ and λ = κ − 2μ/3, that is, the bulk modulus is κ.
class Yeoh : public IsotropicMaterial<Yeoh> {
 public:
  static constexpr const char* kName = "yeoh";
  static constexpr const char* kTitle = "Yeoh";
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr bool kHasVolumetricPart = false;
  static constexpr std::array<MaterialParameter, 4> kParameters{{
      {"c10", "Pa", kModeratePositive, "C₁₀, half the shear modulus of small strains"},
      {"c20", "Pa", kModerate, "C₂₀, often negative"},
      {"c30", "Pa", kModerate, "C₃₀"},
      {"kappa", "Pa", kModeratePositive, "bulk modulus κ"},
  }};
  /// The parameters that are given together with Young's modulus and Poisson's ratio.
  static constexpr std::array<MaterialParameter, 2> kBesideYoung{kParameters[1], kParameters[2]};

  /// The parameters as the formulas use them. T is double, or a vector with one element in each lane.
  template <class T>
  struct Parameters {
    T c10;
    T c20;
    T c30;
    T kappa;
  };

  /// Throws InputError unless C₁₀ > 0, κ ≥ 0 and all are finite. κ = 0: no volumetric part.
  Yeoh(double c10, double c20, double c30, double kappa);
  /// Makes a material with these small-strain parameters.
  static Yeoh from_young(const LameParameters& lame, double c20, double c30);
  static Yeoh like(const LameParameters& lame) {
    return from_young(lame, -0.1 * lame.mu, 0.05 * lame.mu);
  }
  LameParameters initial_lame() const { return {2.0 * c10(), kappa() - 4.0 / 3.0 * c10()}; }
  VolumetricLaw volumetric_law() const { return {kappa(), false}; }
  Yeoh without_volumetric_part() const { return {c10(), c20(), c30(), 0.0}; }
  /// Ψ falls where ∂Ψ/∂Ī₁ ≤ 0. The warning names the stretch λ of incompressible uniaxial tension,
  /// Ī₁ = λ² + 2/λ.
  std::string instability() const;
  double c10() const { return parameters_.c10; }      ///< Pa
  double c20() const { return parameters_.c20; }      ///< Pa
  double c30() const { return parameters_.c30; }      ///< Pa
  double kappa() const { return parameters_.kappa; }  ///< Pa

  /// The least x = Ī₁ − 3 ≥ 0 at which ∂Ψ/∂Ī₁ = C₁₀ + 2 C₂₀ x + 3 C₃₀ x² is not positive; infinite
  /// if it is positive everywhere. It is finite if C₃₀ < 0, or if C₂₀ < 0 and C₂₀² ≥ 3 C₁₀ C₃₀.
  double unstable_from() const;
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, in the order of kParameters.
  std::array<double, 4> parameter_values() const { return {c10(), c20(), c30(), kappa()}; }

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
