// The common base of the program's isotropic materials.
#pragma once

#include "tetraction/material/material_concept.h"
#include "tetraction/material/material_parameter.h"

namespace tetraction {

/// The volumetric part of a law, a function of J alone.
enum class VolumetricPart {
  kLogarithmic,  ///< λ/2 (ln J)²
  kQuadratic     ///< λ/2 (J − 1)²
};

/// Base of an isotropic material M, Ψ(F) = Ψ(I₁, I₂, J) with the invariants of C = FᵀF.
///
/// M provides
/// - kName, its name in scenes, and kTitle, its name for people;
/// - kParameters, the parameters of its constructor in their order;
/// - kBesideYoung, the parameters of from_young() after the Lamé parameters, in their order;
/// - Parameters<T>, the same parameters as numbers of type T in the same order, followed by the
///   volumetric part if there is a choice; parameters(), and parameter_values(), its numbers alone;
/// - kHasVolumetricPart, whether the last argument of both is a VolumetricPart;
/// - kDefinedForAnyJacobian, whether Ψ is also defined for J ≤ 0;
/// - initial_lame().
///
/// The formulas of Ψ and its derivatives with respect to the invariants are in src/material/laws. The
/// functions below and the fast element loops use the same formulas.
template <class M>
class IsotropicMaterial {
 public:
  bool admissible(const Matrix3& f) const {
    if constexpr (M::kDefinedForAnyJacobian) {
      return f.allFinite();
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
