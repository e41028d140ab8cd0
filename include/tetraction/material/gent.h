#pragma once

#include <array>
#include <cmath>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Gent (1996): Ψ = −μ Jm/2 ln(1 − (Ī₁ − 3)/Jm) + κ/2 (J − 1)², Ī₁ = J^{−2/3} I₁. Needs J > 0 and Ī₁ − 3 < Jm: the
/// chains of the rubber are stretched out at this limit, and the energy has no bound there. For large Jm the law
/// is the neo-Hookean one, Yeoh with C₁₀ = μ/2 alone.
///
/// The small-strain parameters are μ and λ = κ − 2μ/3, that is, the bulk modulus is κ.
class Gent : public IsotropicMaterial<Gent> {
 public:
  static constexpr const char* kName = "gent";
  static constexpr const char* kTitle = "Gent";
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr bool kHasVolumetricPart = false;
  /// The least Jm. Ī₁ − 3 of positions in double precision has errors of up to about 1e-15, a ten-millionth of it, and
  /// so has the stiffness.
  static constexpr double kLeastLimit = 1e-8;
  static constexpr std::array<MaterialParameter, 3> kParameters{{
      {"mu", "Pa", kModeratePositive, "shear modulus μ"},
      {"jm",
       "",
       {.least = kLeastLimit,
        .is_moderate = true,
        .advice = ", because a smaller limit is lost in the round-off of positions"},
       "Jm, the limit of Ī₁ − 3"},
      {"kappa", "Pa", kModeratePositive, "bulk modulus κ"},
  }};
  /// The parameters that are given together with Young's modulus and Poisson's ratio.
  static constexpr std::array<MaterialParameter, 1> kBesideYoung{kParameters[1]};

  /// The parameters as the formulas use them. T is double, or a vector with one element in each lane.
  template <class T>
  struct Parameters {
    T mu;
    T jm;
    T kappa;
  };

  /// Throws InputError unless μ > 0, Jm ≥ kLeastLimit, κ ≥ 0 and all are finite. κ = 0: no volumetric part.
  Gent(double mu, double jm, double kappa);
  /// Makes a material with these small-strain parameters.
  static Gent from_young(const LameParameters& lame, double jm) {
    return {lame.mu, jm, lame.lambda + 2.0 / 3.0 * lame.mu};
  }
  static Gent like(const LameParameters& lame) { return from_young(lame, 50.0); }
  LameParameters initial_lame() const { return {mu(), kappa() - 2.0 / 3.0 * mu()}; }
  VolumetricLaw volumetric_law() const { return {kappa(), false}; }
  Gent without_volumetric_part() const { return {mu(), jm(), 0.0}; }
  std::string instability() const { return {}; }  ///< none: the stress grows up to the limit
  /// 1 − (Ī₁ − 3)/Jm.
  double stretch_margin(const Matrix3& f) const;
  double mu() const { return parameters_.mu; }        ///< Pa
  double jm() const { return parameters_.jm; }        ///< the limit of Ī₁ − 3
  double kappa() const { return parameters_.kappa; }  ///< Pa
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, in the order of kParameters.
  std::array<double, 3> parameter_values() const { return {mu(), jm(), kappa()}; }

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
