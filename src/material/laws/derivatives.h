// Arguments and results of a law. A law is Ψ(I₁, I₂, J) of an isotropic material with its
// derivatives, written for a number type N: a double, or a vector with one element in each lane.
//
// Derivatives are taken with respect to I₁, I₂ and ln J, because those with respect to ln J have no
// factors of J: ∂Ψ/∂ln J = J ∂Ψ/∂J and ∂²Ψ/∂(ln J)² = J ∂Ψ/∂J + J² ∂²Ψ/∂J².
#pragma once

#include <type_traits>
#include <utility>

namespace tetraction {

/// Stands for a derivative that vanishes identically. Nothing is computed for it.
struct Zero {};
template <class T>
constexpr bool kIsZero = std::is_same_v<std::remove_cvref_t<T>, Zero>;

/// The arguments of laws that need J > 0. `second` is not defined for laws whose ∂Ψ/∂I₂ is Zero.
template <class N>
struct Invariants {
  N i1;      ///< I₁
  N first;   ///< I₁ − 3 − 2 ln J, without cancellation near rest
  N second;  ///< I₂ − 3 − 4 ln J, likewise
  N log_j;   ///< ln J
  N j;       ///< J
  N growth;  ///< J − 1
};

/// The arguments of laws that are defined for any J, computed from A = C − I. `square` is not
/// defined where derivatives are evaluated.
template <class N>
struct StrainMeasures {
  N trace;   ///< tr A = I₁ − 3
  N square;  ///< tr A² = I₁² − 2 I₂ − 2 I₁ + 3
};

template <class D1, class D2, class DL>
struct FirstDerivatives {
  D1 i1;
  D2 i2;
  DL log_j;
};
template <class D1, class D2, class DL>
FirstDerivatives(D1, D2, DL) -> FirstDerivatives<D1, D2, DL>;

template <class D11, class D12, class D22, class D1L, class D2L, class DLL>
struct SecondDerivatives {
  D11 i1_i1;
  D12 i1_i2;
  D22 i2_i2;
  D1L i1_log_j;
  D2L i2_log_j;
  DLL log_j_log_j;
};
template <class D11, class D12, class D22, class D1L, class D2L, class DLL>
SecondDerivatives(D11, D12, D22, D1L, D2L, DLL) -> SecondDerivatives<D11, D12, D22, D1L, D2L, DLL>;

/// Which terms the derivatives of a law L of material M have.
template <class L, class M>
struct LawTerms {
  static constexpr bool kStrain = M::kDefinedForAnyJacobian;
  using Given = std::conditional_t<kStrain, StrainMeasures<double>, Invariants<double>>;
  using First = decltype(L::first(std::declval<const M&>(), std::declval<const Given&>()));
  using Second = decltype(L::second(std::declval<const M&>(), std::declval<const Given&>()));

  static constexpr bool kI2 = !kIsZero<decltype(First::i2)>;
  /// Whether there are mixed second derivatives with I₂.
  static constexpr bool kI2Coupled = !kIsZero<decltype(Second::i1_i2)> ||
                                     !kIsZero<decltype(Second::i2_i2)> ||
                                     !kIsZero<decltype(Second::i2_log_j)>;
  /// Whether there are second derivatives with I₁ that the terms of a law with I₂ do not contain.
  static constexpr bool kI1Coupled = kI2Coupled || !kIsZero<decltype(Second::i1_log_j)> ||
                                     (!kI2 && !kIsZero<decltype(Second::i1_i1)>);

  static_assert(!kStrain || (kIsZero<decltype(First::log_j)> && !kI1Coupled),
                "A law that is defined for any J depends on I₁ and linearly on I₂ alone.");
};

}  // namespace tetraction
