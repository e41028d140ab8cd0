#if defined(TETRACTION_MATERIAL_GENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_GENT_INL_H_
#undef TETRACTION_MATERIAL_GENT_INL_H_
#else
#define TETRACTION_MATERIAL_GENT_INL_H_
#endif

#include "isochoric-inl.h"
#include "tetraction/material/gent.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = −μ Jm/2 ln(1 − x/Jm) + κ/2 (J − 1)², x = Ī₁ − 3.
template <>
struct Law<Gent> {
  template <class P, class Real>
  static HWY_INLINE Real margin(const P& m, const Invariants<Real>& s) {
    return Real(1.0) - Isochoric<Real>(s).x / Real(m.jm);
  }
  template <class P, class Real>
  static HWY_INLINE Isochoric<Real> isochoric(const P& m, const Invariants<Real>& s) {
    Isochoric<Real> iso(s);
    const Real margin = Real(1.0) - iso.x / Real(m.jm);
    iso.w1 = Real(0.5 * m.mu) / margin;
    iso.w2 = iso.w1 / (Real(m.jm) * margin);
    return iso;
  }

  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const Invariants<Real>& s) {
    const Isochoric<Real> iso(s);
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    const Real log = log_of_1_plus(-iso.x / Real(m.jm));
    return mul_add(Real(-0.5 * m.mu) * Real(m.jm), log, Real(m.kappa) * volumetric.energy);
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
