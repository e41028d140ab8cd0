#if defined(TETRACTION_MATERIAL_YEOH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_YEOH_INL_H_
#undef TETRACTION_MATERIAL_YEOH_INL_H_
#else
#define TETRACTION_MATERIAL_YEOH_INL_H_
#endif

#include "isochoric-inl.h"
#include "tetraction/material/yeoh.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = C₁₀ x + C₂₀ x² + C₃₀ x³ + κ/2 (J − 1)², x = Ī₁ − 3.
template <>
struct Law<Yeoh> {
  template <class P, class Real>
  static HWY_INLINE Isochoric<Real> isochoric(const P& m, const Invariants<Real>& s) {
    Isochoric<Real> iso(s);
    iso.w1 = mul_add(iso.x, mul_add(iso.x, Real(3.0 * m.c30), Real(2.0 * m.c20)), Real(m.c10));
    iso.w2 = mul_add(iso.x, Real(6.0 * m.c30), Real(2.0 * m.c20));
    return iso;
  }

  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const Invariants<Real>& s) {
    const Isochoric<Real> iso(s);
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real factor = mul_add(iso.x, mul_add(iso.x, Real(m.c30), Real(m.c20)), Real(m.c10));
    return mul_add(iso.x, factor, Real(m.kappa) * volumetric.energy);
  }
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P& m, const Invariants<Real>& s) {
    return isochoric(m, s).first_derivatives(Real(m.kappa), s);
  }
  template <class P, class Real>
  static HWY_INLINE auto second_derivatives(const P& m, const Invariants<Real>& s) {
    return isochoric(m, s).second_derivatives(Real(m.kappa), s);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
