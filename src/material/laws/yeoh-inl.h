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
  template <class N>
  struct Isochoric {
    N p;   // J^{−2/3}
    N x;   // Ī₁ − 3
    N w1;  // ∂Ψ/∂Ī₁
    N w2;  // ∂²Ψ/∂Ī₁²

    HWY_INLINE Isochoric(const Yeoh& m, const Invariants<N>& s) {
      const N u = N(2.0 / 3.0) * s.log_j;
      p = exponential(-u);
      // Ī₁ − 3 = p (I₁ − 3 − 2 ln J) + 3 (e^{−u} (1 + u) − 1), and near rest the second term is
      // 3 Σ_{n≥2} (−1)ⁿ (1 − n)/n! uⁿ. The first one left out is below 1e-17 of the sum.
      constexpr double kNear = 0.125;
      N sum = 0.0;
      double factorial = 479001600.0;  // 12!
      for (int n = 12; n >= 2; --n) {
        sum = mul_add(sum, u, N((n % 2 == 0 ? 1.0 : -1.0) * (1 - n) / factorial));
        factorial /= n;
      }
      const N near = mul_add(p, s.first, N(3.0) * (u * u * sum));
      x = where_small(u, kNear, near, mul_sub(p, s.i1, N(3.0)));
      w1 = mul_add(x, mul_add(x, N(3.0 * m.c30()), N(2.0 * m.c20())), N(m.c10()));
      w2 = mul_add(x, N(6.0 * m.c30()), N(2.0 * m.c20()));
    }
  };

  template <class N>
  static HWY_INLINE N energy(const Yeoh& m, const Invariants<N>& s) {
    const Isochoric<N> iso(m, s);
    const Volumetric<N> volumetric(VolumetricPart::kQuadratic, s);
    const N factor = mul_add(iso.x, mul_add(iso.x, N(m.c30()), N(m.c20())), N(m.c10()));
    return mul_add(iso.x, factor, N(m.kappa()) * volumetric.energy);
  }
  template <class N>
  static HWY_INLINE auto first(const Yeoh& m, const Invariants<N>& s) {
    const Isochoric<N> iso(m, s);
    const Volumetric<N> volumetric(VolumetricPart::kQuadratic, s);
    const N shape = N(-2.0 / 3.0) * (iso.x + N(3.0));  // ∂Ī₁/∂ln J
    return FirstDerivatives{iso.p * iso.w1,            // I₁
                            Zero(),                    // I₂
                            mul_add(shape, iso.w1, N(m.kappa()) * volumetric.first)};  // ln J
  }
  template <class N>
  static HWY_INLINE auto second(const Yeoh& m, const Invariants<N>& s) {
    const Isochoric<N> iso(m, s);
    const Volumetric<N> volumetric(VolumetricPart::kQuadratic, s);
    const N i1_bar = iso.x + N(3.0);
    const N change = mul_add(i1_bar, iso.w2, iso.w1);
    return SecondDerivatives{
        iso.p * iso.p * iso.w2,  // I₁ I₁
        Zero(),
        Zero(),
        N(-2.0 / 3.0) * iso.p * change,  // I₁ ln J
        Zero(),
        mul_add(N(4.0 / 9.0) * i1_bar, change, N(m.kappa()) * volumetric.second)};  // ln J ln J
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
