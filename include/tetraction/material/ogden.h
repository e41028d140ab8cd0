#pragma once

#include <array>
#include <span>
#include <vector>

#include "tetraction/material/isotropic_material.h"

namespace tetraction {

/// Ogden (1972): Ψ = Σ_{p=1..n} μₚ/αₚ (λ̄₁^αₚ + λ̄₂^αₚ + λ̄₃^αₚ − 3) + κ/2 (J − 1)² with the principal stretches
/// λ̄ᵢ = J^{−1/3} λᵢ of the isochoric deformation, and 1 to 8 terms. Needs J > 0.
///
/// The small-strain parameters are μ = ½ Σ μₚ αₚ and λ = κ − 2μ/3, that is, the bulk modulus is κ. A term with
/// μₚ αₚ > 0 is stable at all stretches. Terms with μₚ αₚ < 0 are accepted if μ > 0; see instability().
class Ogden : public IsotropicMaterial<Ogden> {
 public:
  static constexpr const char* kName = "ogden";
  static constexpr const char* kTitle = "Ogden";
  static constexpr bool kDefinedForAnyJacobian = false;
  static constexpr bool kHasVolumetricPart = false;
  static constexpr bool kPrincipalStretches = true;
  static constexpr int kMostTerms = 8;
  static constexpr std::array<MaterialParameter, 3> kParameters{{
      {"mu", "Pa", kModerate, "moduli μₚ of the terms", kMostTerms},
      {"alpha", "", kModerate, "exponents αₚ of the terms, not 0", kMostTerms},
      {"kappa", "Pa", kModeratePositive, "bulk modulus κ"},
  }};
  /// The parameters of instead().
  static constexpr std::array<MaterialParameter, 3> kInstead{kParameters[0], kParameters[1],
                                                             kPoissonsRatio};

  /// The parameters as the formulas use them. T is double, or a vector with one element in each lane.
  template <class T>
  struct Parameters {
    T mu[kMostTerms];  // those of terms that are not there are 0
    T alpha[kMostTerms];
    T kappa;
    int terms;
  };
  static constexpr std::size_t kNumbers = 2 * kMostTerms + 1;

  /// Throws InputError unless there are as many αₚ as μₚ, 1 to 8, all are finite, no αₚ is 0, ½ Σ μₚ αₚ > 0 and
  /// κ ≥ 0. κ = 0: no volumetric part.
  Ogden(const std::vector<double>& mu, const std::vector<double>& alpha, double kappa);
  /// With the bulk modulus of small strains that follows from μ and Poisson's ratio, 2μ(1 + ν)/(3(1 − 2ν)).
  static Ogden instead(const std::vector<double>& mu, const std::vector<double>& alpha,
                       double poissons_ratio);
  static Ogden like(const LameParameters& lame);
  LameParameters initial_lame() const;
  VolumetricLaw volumetric_law() const { return {kappa(), false}; }
  Ogden without_volumetric_part() const;
  /// The energy of incompressible uniaxial tension or compression falls at some stretch from 0.1 to 10.
  std::string instability() const;
  int term_count() const { return parameters_.terms; }
  std::span<const double> mu() const;                 ///< μₚ, Pa
  std::span<const double> alpha() const;              ///< αₚ
  double kappa() const { return parameters_.kappa; }  ///< Pa
  const Parameters<double>& parameters() const { return parameters_; }
  /// The numbers among them, kMostTerms μₚ first, then kMostTerms αₚ and κ.
  std::array<double, kNumbers> parameter_values() const;
  /// A material with as many terms and these numbers, in the order of parameter_values().
  Ogden with_values(const double* values) const;

 private:
  Parameters<double> parameters_;
};

}  // namespace tetraction
