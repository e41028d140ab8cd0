#pragma once

#include <array>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Neo-Hookean: Ψ = μ/2 (I₁ − 3 − 2 ln J) + U(J), I₁ = tr C. Needs J > 0.
/// U = λ/2 (ln J)², or with VolumetricPart::kQuadratic U = λ/2 (J − 1)².
class NeoHookean : public IsotropicMaterial<NeoHookean> {
 public:
  static constexpr const char* kName = "neo-hookean";
  static constexpr const char* kTitle = "neo-Hookean";
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr bool kHasVolumetricPart = true;
  static constexpr std::array<MaterialParameter, 2> kParameters{{
      {"mu", "Pa", kModeratePositive, "shear modulus μ"},
      {"lambda", "Pa", kModerate, "first Lamé parameter λ"},
  }};
  /// The parameters that are given together with Young's modulus and Poisson's ratio.
  static constexpr std::array<MaterialParameter, 0> kBesideYoung{};

  /// The parameters as the formulas use them. T is double, or a vector with one element in each lane.
  template <class T>
  struct Parameters {
    T mu;
    T lambda;
    VolumetricPart volumetric;
  };

  /// Throws InputError unless μ > 0, λ > −2μ/3 and both are finite.
  NeoHookean(double mu, double lambda, VolumetricPart volumetric = VolumetricPart::kLogarithmic);
  /// Makes a material with these small-strain parameters.
  static NeoHookean from_young(const LameParameters& lame, VolumetricPart volumetric) {
    return {lame.mu, lame.lambda, volumetric};
  }
  static NeoHookean like(const LameParameters& lame) { return {lame.mu, lame.lambda}; }
  LameParameters initial_lame() const { return {mu(), lambda()}; }
  VolumetricLaw volumetric_law() const {
    return {lambda(), volumetric() == VolumetricPart::kLogarithmic};
  }
  NeoHookean without_volumetric_part() const { return {mu(), 0.0, volumetric()}; }
  std::string instability() const;
  double mu() const { return parameters_.mu; }          ///< Pa
  double lambda() const { return parameters_.lambda; }  ///< Pa
  VolumetricPart volumetric() const { return parameters_.volumetric; }
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, in the order of kParameters.
  std::array<double, 2> parameter_values() const { return {mu(), lambda()}; }

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
