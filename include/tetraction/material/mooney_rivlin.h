#pragma once

#include <array>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Mooney–Rivlin: Ψ = μ₁/2 (I₁ − 3 − 2 ln J) + μ₂/2 (I₂ − 3 − 4 ln J) + U(J),
/// I₂ = ½(I₁² − tr C²); μ₁ = 2 C₁₀ and μ₂ = 2 C₀₁ of the textbooks. Needs J > 0.
/// U = λ/2 (ln J)², or with VolumetricPart::kQuadratic U = λ/2 (J − 1)².
/// With μ₂ = 0 the material is the same as NeoHookean. Its small-strain parameters are μ = μ₁ + μ₂ and λ + 2μ₂ (not λ).
class MooneyRivlin : public IsotropicMaterial<MooneyRivlin> {
 public:
  static constexpr const char* kName = "mooney-rivlin";
  static constexpr const char* kTitle = "Mooney–Rivlin";
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr bool kHasVolumetricPart = true;
  static constexpr std::array<MaterialParameter, 3> kParameters{{
      {"mu1", "Pa", kModerateNotNegative, "μ₁ = 2 C₁₀"},
      {"mu2", "Pa", kModerateNotNegative, "μ₂ = 2 C₀₁"},
      {"lambda", "Pa", kModerate, "λ of the volumetric part"},
  }};
  /// The parameters that are given together with Young's modulus and Poisson's ratio.
  static constexpr std::array<MaterialParameter, 1> kBesideYoung{{
      {"ratio", "", kNotNegative, "μ₂/μ₁"},
  }};

  /// The parameters as the formulas use them. T is double, or a vector with one element in each lane.
  template <class T>
  struct Parameters {
    T mu1;
    T mu2;
    T lambda;
    VolumetricPart volumetric;
  };

  /// Throws InputError unless μ₁ ≥ 0, μ₂ ≥ 0, μ₁ + μ₂ > 0, all are finite, and the small-strain
  /// λ + 2μ₂ > −2(μ₁ + μ₂)/3.
  MooneyRivlin(double mu1, double mu2, double lambda,
               VolumetricPart volumetric = VolumetricPart::kLogarithmic);
  /// Makes a material with these small-strain parameters and μ₂/μ₁ = `ratio` ≥ 0: μ₁ = μ/(1 + ratio), μ₂ = μ −
  /// μ₁, and its λ is λ(E, ν) − 2μ₂. Throws InputError for a ratio out of range.
  static MooneyRivlin from_young(const LameParameters& lame, double ratio,
                                 VolumetricPart volumetric = VolumetricPart::kLogarithmic);
  static MooneyRivlin like(const LameParameters& lame);
  LameParameters initial_lame() const { return {mu1() + mu2(), lambda() + 2.0 * mu2()}; }
  VolumetricLaw volumetric_law() const {
    return {lambda(), volumetric() == VolumetricPart::kLogarithmic};
  }
  MooneyRivlin without_volumetric_part() const { return {mu1(), mu2(), 0.0, volumetric()}; }
  std::string instability() const;
  double mu1() const { return parameters_.mu1; }        ///< Pa
  double mu2() const { return parameters_.mu2; }        ///< Pa
  double lambda() const { return parameters_.lambda; }  ///< Pa
  VolumetricPart volumetric() const { return parameters_.volumetric; }
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, in the order of kParameters.
  std::array<double, 3> parameter_values() const { return {mu1(), mu2(), lambda()}; }

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
