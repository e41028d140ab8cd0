// What the isotropic materials of the program have in common.
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
/// M gives its name in scenes, kName, and for people, kTitle; its parameters, kParameters, in the order
/// of its constructor, and kBesideYoung, in the order of from_young(); whether a VolumetricPart comes
/// last in both, kHasVolumetricPart; initial_lame(); and whether Ψ is defined for J ≤ 0, too,
/// kDefinedForAnyJacobian. Ψ and its derivatives with respect to the invariants stand once, in
/// src/material/laws; what is declared here and the fast element loops are made of them.
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
