// The mean stress of a step for laws in principal stretches. Highway includes this file once for each instruction set.
#if defined(TETRACTION_FEM_DISCRETE_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_DISCRETE_PRINCIPAL_INL_H_
#undef TETRACTION_FEM_DISCRETE_PRINCIPAL_INL_H_
#else
#define TETRACTION_FEM_DISCRETE_PRINCIPAL_INL_H_
#endif

#include "discrete_geometry-inl.h"
#include "fem/discrete_stress.h"
#include "principal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

// Laws in principal stretches.
template <class M>
struct PrincipalStress {
  // The energy and the stress 2 ∂Ψ/∂c of a metric c.
  struct Point {
    Symmetric<Vec> c;
    PrincipalFrame<Tag> frame;
    Symmetric<Vec> inverse;  // c⁻¹
    Volumetric<Real> volumetric;

    HWY_INLINE Point(const Symmetric<Vec>& metric_of_edges, const Columns<Vec>& l,
                     const Geometry& at)
        : c(metric_of_edges),
          frame(PrincipalFrame<Tag>::of_metric(Tag(), c, l)),
          volumetric(VolumetricPart::kQuadratic, invariants(at)) {}
    template <class P>
    HWY_INLINE Real energy(const P& material) const {
      return mul_add(Real(material.kappa), volumetric.energy,
                     frame.stretches.template energy<Law<M>>(material));
    }
    template <class P>
    HWY_INLINE void stress(const P& material, Symmetric<Vec>& result) const {
      Real s[3];
      frame.stretches.template stress<Law<M>>(material, s);
      frame.stress(s, Real(1.0), result);
      add_scaled(Real(material.kappa) * volumetric.first_derivative, inverse, result);
    }

   private:
    // Sets the inverse as well.
    HWY_INLINE Invariants<Real> invariants(const Geometry& at) {
      const Real det = cofactors_of(c, inverse);
      scale(quotient(Real(1.0), det), inverse);
      // The quadratic part uses J and J − 1 only.
      const Real zero(0.0);
      const Real j = Real(hn::Sqrt(det.v)) * at.inverse_six_volume;
      return {zero, zero, zero, zero, j, j - Real(1.0)};
    }
  };

  Columns<Vec> l;  // G = l lᵀ
  Point middle;
  Real factor = 0.0;      // γ
  Real square = 0.0;      // δ:GδG
  Symmetric<Vec> stress;  // s̄

  // c(t).
  static HWY_INLINE Symmetric<Vec> metric_at(const Geometry& at, Real t) {
    Symmetric<Vec> c = at.c;
    add_scaled(t, at.dc, c);
    return c;
  }
  // φ(t).
  template <class P>
  HWY_INLINE Real rate(const P& material, const Geometry& at, Real t) const {
    Symmetric<Vec> s;
    Point(metric_at(at, t), l, at).stress(material, s);
    return Real(0.5) * contract(s, at.dc);
  }

  template <class P>
  HWY_INLINE PrincipalStress(const P& material, const Geometry& at, Real viscous)
      : l(cholesky(Tag(), at.g)), middle(at.c, l, at), square(at.square) {
    const Tag tag;
    middle.stress(material, stress);
    const Real rate0 = Real(0.5) * contract(stress, at.dc);
    Columns<Vec> z;
    symmetric_times(middle.inverse, at.dc, z);
    const auto small = hn::Lt(trace_of_square(tag, z), hn::Set(tag, kSmallStep * kSmallStep));
    Real numerator(0.0);
    if (!hn::AllFalse(tag, small)) {
      for (int k = 0; k < 2; ++k) {
        const Real t(kGaussPoints[k]);
        const Real pair = rate(material, at, t) + rate(material, at, -t);
        numerator = mul_add(Real(kGaussWeights[k]), pair - (rate0 + rate0), numerator);
      }
    }
    if (HWY_UNLIKELY(!hn::AllTrue(tag, small))) {
      const Real difference = Point(metric_at(at, Real(1.0)), l, at).energy(material) -
                              Point(metric_at(at, Real(-1.0)), l, at).energy(material) -
                              (rate0 + rate0);
      numerator = Real(hn::IfThenElse(small, numerator.v, difference.v));
    }
    const auto moves = hn::Gt(square.v, hn::Set(tag, 1e-200));
    const Real divisor(hn::IfThenElse(moves, square.v, hn::Set(tag, 1.0)));
    factor = Real(hn::IfThenElse(moves, quotient(numerator, divisor).v, hn::Zero(tag)));
    add_scaled(factor + viscous, at.gdg, stress);
    scale(at.volume, stress);
  }

  // ṡ of the stress at t = 0 without the factor V.
  template <class P>
  HWY_INLINE void middle_derivative(const P& material, const Symmetric<Vec>& b,
                                    Symmetric<Vec>& result) const {
    const auto tangent =
        PrincipalTangent<Real>::template of<Law<M>>(material, middle.frame.stretches);
    const Columns<Vec>& axes = middle.frame.b;
    Real along[3][3];  // bᵢᵀ b bⱼ
    for (int j = 0; j < 3; ++j) {
      Vec image[3];
      for (int r = 0; r < 3; ++r) {
        image[r] = hn::MulAdd(b(r, 2), axes.m[j][2],
                              hn::MulAdd(b(r, 1), axes.m[j][1], hn::Mul(b(r, 0), axes.m[j][0])));
      }
      for (int i = 0; i < 3; ++i) {
        along[i][j] =
            Real(hn::MulAdd(axes.m[i][2], image[2],
                            hn::MulAdd(axes.m[i][1], image[1], hn::Mul(axes.m[i][0], image[0]))));
      }
    }
    Real change[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        change[i][j] = i == j ? tangent.h[i][0] * along[0][0] + tangent.h[i][1] * along[1][1] +
                                    tangent.h[i][2] * along[2][2]
                              : tangent.theta[3 - i - j] * along[i][j];
      }
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) {
        Real sum(0.0);
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            sum = mul_add(change[i][j] * Real(axes.m[i][r]), Real(axes.m[j][c]), sum);
          }
        }
        result(r, c) = sum.v;
      }
    }
    const Real kappa(material.kappa);
    const Real half = Real(0.5) * contract(middle.inverse, b);
    add_scaled(kappa * middle.volumetric.second_derivative * half, middle.inverse, result);
    Columns<Vec> b_inverse;
    symmetric_times(b, middle.inverse, b_inverse);
    Symmetric<Vec> product;
    symmetric_product(middle.inverse, b_inverse, product);
    add_scaled(-(kappa * middle.volumetric.first_derivative), product, result);
  }

  template <class P>
  HWY_INLINE void derivative(const P& material, const Geometry& at, Real viscous,
                             const Symmetric<Vec>& b, Symmetric<Vec>& result) const {
    const Tag tag;
    middle_derivative(material, b, result);
    // y:b.
    Symmetric<Vec> end;
    Point(metric_at(at, Real(1.0)), l, at).stress(material, end);
    const Real change = contract(b, at.gdg);
    Real along = contract(end, b) - mul_sub(quotient(Real(1.0), at.volume), contract(stress, b),
                                            (factor + viscous) * change);
    along = along - contract(result, at.dc) - Real(2.0) * factor * change;
    const auto moves = hn::Gt(square.v, hn::Set(tag, kLeastStrainChange));
    const Real divisor(hn::IfThenElse(moves, square.v, hn::Set(tag, 1.0)));
    const Real factor_rate(hn::IfThenElse(moves, quotient(along, divisor).v, hn::Zero(tag)));
    add_scaled(factor_rate, at.gdg, result);
    Columns<Vec> bg;
    symmetric_times(b, at.g, bg);
    Symmetric<Vec> gbg;
    symmetric_product(at.g, bg, gbg);
    add_scaled(factor + viscous, gbg, result);
    scale(at.volume, result);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
