// Arguments and results of a material law. A law is the energy density Ψ(I₁, I₂, J) of an isotropic
// material with its derivatives. It is written as templates over the type Real of the numbers: a
// double, or a vector that holds one element in each lane.
//
// Derivatives are taken with respect to I₁, I₂ and ln J. Those with respect to ln J have simple
// formulas, ∂Ψ/∂ln J = J ∂Ψ/∂J and ∂²Ψ/∂(ln J)² = J ∂Ψ/∂J + J² ∂²Ψ/∂J².
#pragma once

#include <type_traits>
#include <utility>

namespace tetraction {

/// The type of a derivative that vanishes identically. The compiler omits the terms that contain it.
struct Zero {};
template <class T>
constexpr bool kIsZero = std::is_same_v<std::remove_cvref_t<T>, Zero>;

/// The arguments of laws that need J > 0. `i2_term` is not defined for laws whose ∂Ψ/∂I₂ is Zero.
template <class Real>
struct Invariants {
  Real i1;             ///< I₁
  Real i1_term;        ///< I₁ − 3 − 2 ln J, computed without cancellation near rest
  Real i2_term;        ///< I₂ − 3 − 4 ln J, computed without cancellation near rest
  Real log_j;          ///< ln J
  Real j;              ///< J
  Real volume_change;  ///< J − 1
};

/// The arguments of laws that are defined for any J, computed from A = C − I. `square` is not
/// defined where only derivatives are evaluated, because they do not depend on it.
template <class Real>
struct StrainMeasures {
  Real trace;   ///< tr A = I₁ − 3
  Real square;  ///< tr A² = I₁² − 2 I₂ − 2 I₁ + 3
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

/// Tells at compile time which derivatives a law L of material M has.
template <class L, class M>
struct LawTerms {
  static constexpr bool kPrincipal = false;
  /// Whether the arguments are StrainMeasures.
  static constexpr bool kStrain = M::kDefinedForAnyJacobian;
  using Arguments = std::conditional_t<kStrain, StrainMeasures<double>, Invariants<double>>;
  using Parameters = typename M::template Parameters<double>;
  using First = decltype(L::first_derivatives(std::declval<const Parameters&>(),
                                              std::declval<const Arguments&>()));
  using Second = decltype(L::second_derivatives(std::declval<const Parameters&>(),
                                                std::declval<const Arguments&>()));

  /// Whether ∂Ψ/∂I₂ exists.
  static constexpr bool kI2 = !kIsZero<decltype(First::i2)>;
  /// Whether any second derivative with respect to I₂ exists.
  static constexpr bool kI2Coupled = !kIsZero<decltype(Second::i1_i2)> ||
                                     !kIsZero<decltype(Second::i2_i2)> ||
                                     !kIsZero<decltype(Second::i2_log_j)>;
  /// Whether any second derivative exists besides ∂²Ψ/∂(ln J)². If ∂Ψ/∂I₂ exists, ∂²Ψ/∂I₁² does not
  /// count, because the metric terms of fem/kernels/tangent_kernels.h contain it.
  static constexpr bool kI1Coupled = kI2Coupled || !kIsZero<decltype(Second::i1_log_j)> ||
                                     (!kI2 && !kIsZero<decltype(Second::i1_i1)>);

  static_assert(!kStrain || (kIsZero<decltype(First::log_j)> && !kI1Coupled),
                "A law that is defined for any J depends on I₁ and linearly on I₂ alone.");
};
/// A law in principal stretches has no derivatives with respect to invariants.
template <class L, class M>
requires(M::kPrincipalStretches) struct LawTerms<L, M> {
  static constexpr bool kPrincipal = true;
  static constexpr bool kStrain = false;
  static constexpr bool kI2 = false;
  static constexpr bool kI1Coupled = false;
  static constexpr bool kI2Coupled = false;
};

}  // namespace tetraction
