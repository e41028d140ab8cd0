// The invariant Ī₁ of the isochoric part of the deformation, for laws Ψ = W(Ī₁) + U(J). Highway includes this
// file once for each instruction set.
#if defined(TETRACTION_MATERIAL_ISOCHORIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_ISOCHORIC_INL_H_
#undef TETRACTION_MATERIAL_ISOCHORIC_INL_H_
#else
#define TETRACTION_MATERIAL_ISOCHORIC_INL_H_
#endif

#include "volumetric-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// x = Ī₁ − 3 with Ī₁ = p I₁, p = J^{−2/3}, and the derivatives of W with respect to it. They give those of Ψ by
/// ∂Ī₁/∂I₁ = p and ∂Ī₁/∂ln J = −⅔ Ī₁.
template <class Real>
struct Isochoric {
  Real p;         ///< J^{−2/3}
  Real x;         ///< Ī₁ − 3
  Real w1 = 0.0;  ///< ∂W/∂Ī₁
  Real w2 = 0.0;  ///< ∂²W/∂Ī₁²

  HWY_INLINE explicit Isochoric(const Invariants<Real>& s) {
    const Real u = Real(2.0 / 3.0) * s.log_j;
    p = exponential(-u);
    // Ī₁ − 3 = p (I₁ − 3 − 2 ln J) + 3 (e^{−u} (1 + u) − 1) with u = ⅔ ln J. Near rest the second
    // term is computed as the series 3 Σ_{n≥2} (−1)ⁿ (1 − n)/n! uⁿ, which does not cancel. The
    // first term that is left out is below 1e-17 of the sum.
    constexpr double kNear = 0.125;
    Real sum = 0.0;
    double factorial = 479001600.0;  // 12!
    for (int n = 12; n >= 2; --n) {
      sum = mul_add(sum, u, Real((n % 2 == 0 ? 1.0 : -1.0) * (1 - n) / factorial));
      factorial /= n;
    }
    const Real near = mul_add(p, s.i1_term, Real(3.0) * (u * u * sum));
    x = where_small(u, kNear, near, mul_sub(p, s.i1, Real(3.0)));
  }

  /// The derivatives of Ψ, with the volumetric part U = κ/2 (J − 1)².
  HWY_INLINE auto first_derivatives(Real kappa, const Invariants<Real>& s) const {
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real i1_bar_derivative = Real(-2.0 / 3.0) * (x + Real(3.0));  // ∂Ī₁/∂ln J
    return FirstDerivatives{
        p * w1,                                                                // I₁
        Zero(),                                                                // I₂
        mul_add(i1_bar_derivative, w1, kappa * volumetric.first_derivative)};  // ln J
  }
  HWY_INLINE auto second_derivatives(Real kappa, const Invariants<Real>& s) const {
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real i1_bar = x + Real(3.0);
    const Real weighted = mul_add(i1_bar, w2, w1);
    return SecondDerivatives{p * p * w2,  // I₁ I₁
                             Zero(),
                             Zero(),
                             Real(-2.0 / 3.0) * p * weighted,  // I₁ ln J
                             Zero(),
                             mul_add(Real(4.0 / 9.0) * i1_bar, weighted,
                                     kappa * volumetric.second_derivative)};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
