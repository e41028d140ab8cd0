// The common base of the program's isotropic materials.
#pragma once

#include <array>
#include <concepts>
#include <string>
#include <utility>

#include "tetraction/material/material_concept.h"
#include "tetraction/material/material_parameter.h"
#include "tetraction/material/volumetric_law.h"

namespace tetraction {

/// A material whose energy grows without bound at a finite stretch. stretch_margin(F) is 1 at rest, positive
/// where Ψ is defined, and 0 at the limit.
template <class M>
concept HasStretchLimit = requires(const M& m, const Matrix3& f) {
  { m.stretch_margin(f) } -> std::convertible_to<double>;
};

/// The number of numbers that are the parameters of M, all entries of lists included.
template <class M>
constexpr std::size_t number_count() {
  return std::tuple_size_v<decltype(std::declval<const M&>().parameter_values())>;
}

/// Base of an isotropic material M, Ψ(F) = Ψ(I₁, I₂, J) with the invariants of C = FᵀF.
///
/// M provides
/// - kName, its name in scenes, and kTitle, its name for people;
/// - kParameters, the parameters of its constructor in their order;
/// - kBesideYoung, the parameters of from_young() after the Lamé parameters, in their order; or, of a material
///   that cannot be given by Young's modulus, kInstead, the parameters of its function instead();
/// - Parameters<T>, the same parameters as numbers of type T in the same order, all entries of lists included,
///   followed by the volumetric part or the number of terms if there is a choice; parameters(), and
///   parameter_values(), its numbers alone;
/// - kHasVolumetricPart, whether the last argument of both is a VolumetricPart;
/// - kDefinedForAnyJacobian, whether Ψ is also defined for J ≤ 0;
/// - initial_lame();
/// - like(lame), a material of usual parameters with these small-strain parameters, for checks;
/// - instability(), a warning about parameters with which the energy falls when the strain grows, or "";
/// - volumetric_law() and without_volumetric_part(), if Ψ has a volumetric part (HasVolumetricLaw);
/// - stretch_margin(F), if Ψ is defined only where it is positive (HasStretchLimit);
/// - kPrincipalStretches, if Ψ is Σ w(ln λ̄ᵢ) + U(J) (src/material/laws/principal-inl.h).
///
/// The formulas of Ψ and its derivatives with respect to the invariants are in src/material/laws. The
/// functions below and the fast element loops use the same formulas.
template <class M>
class IsotropicMaterial {
 public:
  static constexpr bool kPrincipalStretches = false;

  bool admissible(const Matrix3& f) const {
    if constexpr (M::kDefinedForAnyJacobian) {
      return f.allFinite();
    } else if constexpr (HasStretchLimit<M>) {
      return jacobian(f) > 0.0 && static_cast<const M&>(*this).stretch_margin(f) > 0.0;
    } else {
      return jacobian(f) > 0.0;
    }
  }
  double energy_density(const Matrix3& f) const;
  Matrix3 first_piola(const Matrix3& f) const;
  Matrix9 stiffness(const Matrix3& f) const;

 private:
  IsotropicMaterial() = default;
  friend M;
};

}  // namespace tetraction
