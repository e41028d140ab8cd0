#if defined(TETRACTION_MATERIAL_MOONEY_RIVLIN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_MOONEY_RIVLIN_INL_H_
#undef TETRACTION_MATERIAL_MOONEY_RIVLIN_INL_H_
#else
#define TETRACTION_MATERIAL_MOONEY_RIVLIN_INL_H_
#endif

#include "tetraction/material/mooney_rivlin.h"
#include "volumetric-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = μ₁/2 (I₁ − 3 − 2 ln J) + μ₂/2 (I₂ − 3 − 4 ln J) + U(J).
template <>
struct Law<MooneyRivlin> {
  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const Invariants<Real>& s) {
    const Volumetric<Real> volumetric(m.volumetric, s);
    const Real without_i2 =
        mul_add(Real(0.5 * m.mu1), s.i1_term, Real(m.lambda) * volumetric.energy);
    return mul_add(Real(0.5 * m.mu2), s.i2_term, without_i2);
  }
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P& m, const Invariants<Real>& s) {
    const Volumetric<Real> volumetric(m.volumetric, s);
    return FirstDerivatives{
        Real(0.5 * m.mu1),                                                                 // I₁
        Real(0.5 * m.mu2),                                                                 // I₂
        mul_sub(Real(m.lambda), volumetric.first_derivative, Real(m.mu1 + 2.0 * m.mu2))};  // ln J
  }
  template <class P, class Real>
  static HWY_INLINE auto second_derivatives(const P& m, const Invariants<Real>& s) {
    const Volumetric<Real> volumetric(m.volumetric, s);
    return SecondDerivatives{Zero(), Zero(),
                             Zero(), Zero(),
                             Zero(), Real(m.lambda) * volumetric.second_derivative};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
