// The hyperelastic materials of the program, and the variant that holds any material. With
// C = FᵀF, E = ½(C − I), J = det F; conventions in material_concept.h. Each is stress-free at F = I.
#pragma once

#include <string>
#include <variant>

#include "tetraction/material/custom_material.h"
#include "tetraction/material/material_concept.h"

namespace tetraction {

/// Saint Venant–Kirchhoff: Ψ = μ E:E + λ/2 (tr E)².
/// Defined for every F; loses stiffness in compression (uniaxial limit at stretch 1/√3).
class StVenantKirchhoff {
 public:
  static constexpr const char* kName = "stvk";
  /// Throws InputError unless μ > 0, λ > −2μ/3 and both are finite.
  StVenantKirchhoff(double mu, double lambda);
  bool admissible(const Matrix3& f) const { return f.allFinite(); }
  double energy_density(const Matrix3& f) const;
  Matrix3 first_piola(const Matrix3& f) const;
  Matrix9 stiffness(const Matrix3& f) const;
  LameParameters initial_lame() const { return {mu_, lambda_}; }
  double mu() const { return mu_; }          ///< Pa
  double lambda() const { return lambda_; }  ///< Pa

 private:
  double mu_;
  double lambda_;
};

/// Neo-Hookean: Ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 (ln J)², I₁ = tr C. Needs J > 0.
class NeoHookean {
 public:
  static constexpr const char* kName = "neo-hookean";
  /// Throws InputError unless μ > 0, λ > −2μ/3 and both are finite.
  NeoHookean(double mu, double lambda);
  bool admissible(const Matrix3& f) const { return jacobian(f) > 0.0; }
  double energy_density(const Matrix3& f) const;
  Matrix3 first_piola(const Matrix3& f) const;
  Matrix9 stiffness(const Matrix3& f) const;
  LameParameters initial_lame() const { return {mu_, lambda_}; }
  double mu() const { return mu_; }          ///< Pa
  double lambda() const { return lambda_; }  ///< Pa

 private:
  double mu_;
  double lambda_;
};

/// Mooney–Rivlin: Ψ = μ₁/2 (I₁ − 3 − 2 ln J) + μ₂/2 (I₂ − 3 − 4 ln J) + λ/2 (ln J)²,
/// I₂ = ½(I₁² − tr C²); μ₁ = 2 C₁₀ and μ₂ = 2 C₀₁ of the textbooks. Needs J > 0.
/// With μ₂ = 0 it is NeoHookean. Its small-strain parameters are μ = μ₁ + μ₂ and λ + 2μ₂ (not λ).
class MooneyRivlin {
 public:
  static constexpr const char* kName = "mooney-rivlin";
  /// Throws InputError unless μ₁ ≥ 0, μ₂ ≥ 0, μ₁ + μ₂ > 0, all are finite, and the small-strain
  /// λ + 2μ₂ > −2(μ₁ + μ₂)/3.
  MooneyRivlin(double mu1, double mu2, double lambda);
  bool admissible(const Matrix3& f) const { return jacobian(f) > 0.0; }
  double energy_density(const Matrix3& f) const;
  Matrix3 first_piola(const Matrix3& f) const;
  Matrix9 stiffness(const Matrix3& f) const;
  LameParameters initial_lame() const { return {mu1_ + mu2_, lambda_ + 2.0 * mu2_}; }
  double mu1() const { return mu1_; }        ///< Pa
  double mu2() const { return mu2_; }        ///< Pa
  double lambda() const { return lambda_; }  ///< Pa

 private:
  double mu1_;
  double mu2_;
  double lambda_;
};

static_assert(Material<StVenantKirchhoff> && Material<NeoHookean> && Material<MooneyRivlin> &&
              Material<CustomMaterial>);

/// A material chosen at run time; visited once outside the element loop.
using MaterialModel = std::variant<StVenantKirchhoff, NeoHookean, MooneyRivlin, CustomMaterial>;

/// The scene's name of the model, "stvk", "neo-hookean", "mooney-rivlin", or the name that a custom
/// material was given.
std::string material_name(const MaterialModel& material);

/// Small-strain Lamé parameters of a model, Pa.
LameParameters initial_lame(const MaterialModel& material);

/// μ = E/(2(1+ν)), λ = Eν/((1+ν)(1−2ν)).
/// Throws InputError unless E > 0 and ν in (−1, 0.5); the message says what to do near ν = 0.5.
LameParameters lame_from_young(double youngs_modulus, double poissons_ratio);

/// Mooney–Rivlin with the small-strain response of (E, ν) and μ₂/μ₁ = `ratio` ≥ 0:
/// μ₁ = μ/(1 + ratio), μ₂ = μ − μ₁, and its λ is λ(E, ν) − 2μ₂.
MooneyRivlin mooney_rivlin_from_young(double youngs_modulus, double poissons_ratio, double ratio);

/// Speed of compression waves √((λ + 2μ)/ρ), m/s.
double wave_speed(const LameParameters& lame, double density);

}  // namespace tetraction
