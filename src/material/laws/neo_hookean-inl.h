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
  template <class N>
  static HWY_INLINE N energy(const NeoHookean& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    return mul_add(N(0.5 * m.mu()), s.first, N(m.lambda()) * volumetric.energy);
  }
  template <class N>
  static HWY_INLINE auto first(const NeoHookean& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    return FirstDerivatives{N(0.5 * m.mu()),                                       // I₁
                            Zero(),                                                // I₂
                            mul_sub(N(m.lambda()), volumetric.first, N(m.mu()))};  // ln J
  }
  template <class N>
  static HWY_INLINE auto second(const NeoHookean& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    return SecondDerivatives{Zero(), Zero(), Zero(),
                             Zero(), Zero(), N(m.lambda()) * volumetric.second};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
