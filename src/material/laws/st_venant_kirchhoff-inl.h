#if defined(TETRACTION_MATERIAL_ST_VENANT_KIRCHHOFF_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_ST_VENANT_KIRCHHOFF_INL_H_
#undef TETRACTION_MATERIAL_ST_VENANT_KIRCHHOFF_INL_H_
#else
#define TETRACTION_MATERIAL_ST_VENANT_KIRCHHOFF_INL_H_
#endif

#include "number-inl.h"
#include "tetraction/material/st_venant_kirchhoff.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// Ψ = μ/4 tr A² + λ/8 (tr A)², since E = A/2.
template <>
struct Law<StVenantKirchhoff> {
  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, const StrainMeasures<Real>& s) {
    return Real(0.25 * m.mu) * s.square + Real(0.125 * m.lambda) * (s.trace * s.trace);
  }
  template <class P, class Real>
  static HWY_INLINE auto first_derivatives(const P& m, const StrainMeasures<Real>& s) {
    return FirstDerivatives{mul_add(Real(0.5 * m.mu + 0.25 * m.lambda), s.trace, Real(m.mu)),  // I₁
                            Real(-0.5 * m.mu),  // I₂
                            Zero()};
  }
  template <class P, class Real>
  static HWY_INLINE Real spherical(const P& m, const StrainMeasures<Real>& s) {
    return Real(0.25 * m.lambda) * s.trace;
  }
  template <class P, class Real>
  static HWY_INLINE auto second_derivatives(const P& m, const StrainMeasures<Real>&) {
    return SecondDerivatives{Real(0.5 * m.mu + 0.25 * m.lambda),  // I₁ I₁
                             Zero(),
                             Zero(),
                             Zero(),
                             Zero(),
                             Zero()};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
