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
  template <class N>
  static HWY_INLINE N energy(const StVenantKirchhoff& m, const StrainMeasures<N>& s) {
    return N(0.25 * m.mu()) * s.square + N(0.125 * m.lambda()) * (s.trace * s.trace);
  }
  template <class N>
  static HWY_INLINE auto first(const StVenantKirchhoff& m, const StrainMeasures<N>& s) {
    return FirstDerivatives{mul_add(N(0.5 * m.mu() + 0.25 * m.lambda()), s.trace, N(m.mu())),  // I₁
                            N(-0.5 * m.mu()),  // I₂
                            Zero()};
  }
  template <class N>
  static HWY_INLINE N spherical(const StVenantKirchhoff& m, const StrainMeasures<N>& s) {
    return N(0.25 * m.lambda()) * s.trace;
  }
  template <class N>
  static HWY_INLINE auto second(const StVenantKirchhoff& m, const StrainMeasures<N>&) {
    return SecondDerivatives{N(0.5 * m.mu() + 0.25 * m.lambda()),  // I₁ I₁
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
