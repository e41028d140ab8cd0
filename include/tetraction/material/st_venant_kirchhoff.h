#pragma once

#include <array>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Saint Venant–Kirchhoff: Ψ = μ E:E + λ/2 (tr E)².
/// It is defined for every F. It loses its stiffness in compression: under uniaxial compression the
/// force has its largest magnitude at the stretch 1/√3.
class StVenantKirchhoff : public IsotropicMaterial<StVenantKirchhoff> {
 public:
  static constexpr const char* kName = "stvk";
  static constexpr const char* kTitle = "Saint Venant–Kirchhoff";
  static constexpr bool kDefinedForAnyJacobian = true;
  static constexpr bool kHasVolumetricPart = false;
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
  };

  /// Throws InputError unless μ > 0, λ > −2μ/3 and both are finite.
  StVenantKirchhoff(double mu, double lambda);
  /// Makes a material with these small-strain parameters.
  static StVenantKirchhoff from_young(const LameParameters& lame) { return {lame.mu, lame.lambda}; }
  static StVenantKirchhoff like(const LameParameters& lame) { return {lame.mu, lame.lambda}; }
  LameParameters initial_lame() const { return {mu(), lambda()}; }
  std::string instability() const { return {}; }        ///< none: Ψ ≥ 0 for every E
  double mu() const { return parameters_.mu; }          ///< Pa
  double lambda() const { return parameters_.lambda; }  ///< Pa
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, in the order of kParameters.
  std::array<double, 2> parameter_values() const { return {mu(), lambda()}; }

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
