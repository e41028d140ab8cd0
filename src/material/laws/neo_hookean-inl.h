#if defined(TETRACTION_MATERIAL_NEO_HOOKEAN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_NEO_HOOKEAN_INL_H_
#undef TETRACTION_MATERIAL_NEO_HOOKEAN_INL_H_
#else
#define TETRACTION_MATERIAL_NEO_HOOKEAN_INL_H_
#endif

#include "tetraction/material/neo_hookean.h"
#include "volumetric-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = μ/2 (I₁ − 3 − 2 ln J) + U(J).
template <>
struct Law<NeoHookean> {
  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const Invariants<Real>& s) {
    const Volumetric<Real> volumetric(m.volumetric, s);
    return mul_add(Real(0.5 * m.mu), s.i1_term, Real(m.lambda) * volumetric.energy);
  }
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P& m, const Invariants<Real>& s) {
    const Volumetric<Real> volumetric(m.volumetric, s);
    return FirstDerivatives{
        Real(0.5 * m.mu),                                                   // I₁
        Zero(),                                                             // I₂
        mul_sub(Real(m.lambda), volumetric.first_derivative, Real(m.mu))};  // ln J
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
