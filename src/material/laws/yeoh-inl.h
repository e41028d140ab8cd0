#if defined(TETRACTION_MATERIAL_YEOH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_YEOH_INL_H_
#undef TETRACTION_MATERIAL_YEOH_INL_H_
#else
#define TETRACTION_MATERIAL_YEOH_INL_H_
#endif

#include "tetraction/material/yeoh.h"
#include "volumetric-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = C₁₀ x + C₂₀ x² + C₃₀ x³ + κ/2 (J − 1)², x = Ī₁ − 3, Ī₁ = p I₁ with p = J^{−2/3}.
///
/// ∂Ī₁/∂I₁ = p and ∂Ī₁/∂ln J = −⅔ Ī₁.
template <>
struct Law<Yeoh> {
  template <class Real>
  struct Isochoric {
    Real p;   // J^{−2/3}
    Real x;   // Ī₁ − 3
    Real w1;  // ∂Ψ/∂Ī₁
    Real w2;  // ∂²Ψ/∂Ī₁²

    template <class P>
    HWY_INLINE Isochoric(const P& m, const Invariants<Real>& s) {
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
      w1 = mul_add(x, mul_add(x, Real(3.0 * m.c30), Real(2.0 * m.c20)), Real(m.c10));
      w2 = mul_add(x, Real(6.0 * m.c30), Real(2.0 * m.c20));
    }
  };

  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const Invariants<Real>& s) {
    const Isochoric<Real> iso(m, s);
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real factor = mul_add(iso.x, mul_add(iso.x, Real(m.c30), Real(m.c20)), Real(m.c10));
    return mul_add(iso.x, factor, Real(m.kappa) * volumetric.energy);
  }
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P& m, const Invariants<Real>& s) {
    const Isochoric<Real> iso(m, s);
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real i1_bar_derivative = Real(-2.0 / 3.0) * (iso.x + Real(3.0));  // ∂Ī₁/∂ln J
    return FirstDerivatives{
        iso.p * iso.w1,                                                                    // I₁
        Zero(),                                                                            // I₂
        mul_add(i1_bar_derivative, iso.w1, Real(m.kappa) * volumetric.first_derivative)};  // ln J
  }
  template <class P, class Real>
  static HWY_INLINE auto second_derivatives(const P& m, const Invariants<Real>& s) {
    const Isochoric<Real> iso(m, s);
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real i1_bar = iso.x + Real(3.0);
    const Real weighted = mul_add(i1_bar, iso.w2, iso.w1);
    return SecondDerivatives{iso.p * iso.p * iso.w2,  // I₁ I₁
                             Zero(),
                             Zero(),
                             Real(-2.0 / 3.0) * iso.p * weighted,  // I₁ ln J
                             Zero(),
                             mul_add(Real(4.0 / 9.0) * i1_bar, weighted,
                                     Real(m.kappa) * volumetric.second_derivative)};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
