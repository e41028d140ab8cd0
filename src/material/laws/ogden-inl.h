#if defined(TETRACTION_MATERIAL_OGDEN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_OGDEN_INL_H_
#undef TETRACTION_MATERIAL_OGDEN_INL_H_
#else
#define TETRACTION_MATERIAL_OGDEN_INL_H_
#endif

#include "principal-inl.h"
#include "tetraction/material/ogden.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// w(ε) = Σ μₚ/αₚ e^{αₚ ε}. The energy is without w(0) + w'(0) ε, and the first derivative without w'(0), which add
/// nothing to Ψ because Σ ln λ̄ᵢ = 0.
template <>
struct Law<Ogden> {
  template <class P, class Real>
  static HWY_INLINE Real energy(const P& m, Real x) {
    Real sum(0.0);
    for (int p = 0; p < m.terms; ++p) {
      sum =
          mul_add(Real(m.mu[p]) / Real(m.alpha[p]), exponential_excess(Real(m.alpha[p]) * x), sum);
    }
    return sum;
  }
  template <class P, class Real>
  static HWY_INLINE Real first_derivative(const P& m, Real x) {
    Real sum(0.0);
    for (int p = 0; p < m.terms; ++p) {
      sum = mul_add(Real(m.mu[p]), exponential_minus_1(Real(m.alpha[p]) * x), sum);
    }
    return sum;
  }
  template <class P, class Real>
  static HWY_INLINE Real second_derivative(const P& m, Real x) {
    Real sum(0.0);
    for (int p = 0; p < m.terms; ++p) {
      sum = mul_add(Real(m.mu[p]) * Real(m.alpha[p]), exponential(Real(m.alpha[p]) * x), sum);
    }
    return sum;
  }
  template <class P, class Real>
  static HWY_INLINE Real difference_quotient(const P& m, Real x, Real y) {
    Real sum(0.0);
    for (int p = 0; p < m.terms; ++p) {
      const Real alpha(m.alpha[p]);
      sum = mul_add(Real(m.mu[p]) * alpha, exponential_quotient(alpha * x, alpha * y), sum);
    }
    return sum;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
