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
  template <class N>
  static HWY_INLINE N energy(const MooneyRivlin& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    const N without_second = mul_add(N(0.5 * m.mu1()), s.first, N(m.lambda()) * volumetric.energy);
    return mul_add(N(0.5 * m.mu2()), s.second, without_second);
  }
  template <class N>
  static HWY_INLINE auto first(const MooneyRivlin& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    return FirstDerivatives{
        N(0.5 * m.mu1()),                                                       // I₁
        N(0.5 * m.mu2()),                                                       // I₂
        mul_sub(N(m.lambda()), volumetric.first, N(m.mu1() + 2.0 * m.mu2()))};  // ln J
  }
  template <class N>
  static HWY_INLINE auto second(const MooneyRivlin& m, const Invariants<N>& s) {
    const Volumetric<N> volumetric(m.volumetric(), s);
    return SecondDerivatives{Zero(), Zero(), Zero(),
                             Zero(), Zero(), N(m.lambda()) * volumetric.second};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
