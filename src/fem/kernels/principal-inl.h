// Laws in principal stretches in the notation of element_kernels.h. Highway includes this file once for each
// instruction set.
//
// With G = L Lᵀ (Cholesky) and B = e L, the matrix BᵀB has the eigenvalues of C: F is B times a rotation of the rest
// state. For each of its eigenvectors nᵢ, bᵢ = L nᵢ is the pulled back one and yᵢ = e bᵢ its image, |yᵢ| = λᵢ. The
// pulled back second Piola–Kirchhoff stress is Σ sᵢ bᵢ ⊗ bᵢ (material/laws/principal-inl.h).
#if defined(TETRACTION_FEM_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_PRINCIPAL_INL_H_
#undef TETRACTION_FEM_PRINCIPAL_INL_H_
#else
#define TETRACTION_FEM_PRINCIPAL_INL_H_
#endif

#include "material/laws/laws-inl.h"
#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

/// The lower triangular L of G = L Lᵀ: l.m[column][row].
template <class Tag>
HWY_INLINE Columns<hn::Vec<Tag>> cholesky(Tag tag, const Symmetric<hn::Vec<Tag>>& g) {
  using Vec = hn::Vec<Tag>;
  Columns<Vec> l;
  const Vec one = hn::Set(tag, 1.0);
  l.m[0][0] = hn::Sqrt(g(0, 0));
  const Vec inverse0 = hn::Div(one, l.m[0][0]);
  l.m[0][1] = hn::Mul(g(0, 1), inverse0);
  l.m[0][2] = hn::Mul(g(0, 2), inverse0);
  l.m[1][0] = hn::Zero(tag);
  l.m[1][1] = hn::Sqrt(hn::NegMulAdd(l.m[0][1], l.m[0][1], g(1, 1)));
  l.m[1][2] = hn::Div(hn::NegMulAdd(l.m[0][1], l.m[0][2], g(1, 2)), l.m[1][1]);
  l.m[2][0] = hn::Zero(tag);
  l.m[2][1] = hn::Zero(tag);
  l.m[2][2] =
      hn::Sqrt(hn::NegMulAdd(l.m[1][2], l.m[1][2], hn::NegMulAdd(l.m[0][2], l.m[0][2], g(2, 2))));
  return l;
}

/// result = a b.
template <class Vec>
HWY_INLINE void product_of(const Columns<Vec>& a, const Columns<Vec>& b, Columns<Vec>& result) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      result.m[j][i] = hn::MulAdd(a.m[2][i], b.m[j][2],
                                  hn::MulAdd(a.m[1][i], b.m[j][1], hn::Mul(a.m[0][i], b.m[j][0])));
    }
  }
}

/// The stretches of edges.
template <class Tag>
struct PrincipalFrame {
  using Vec = hn::Vec<Tag>;
  using Real = Number<Tag>;
  Stretches<Real> stretches;
  Columns<Vec> b;  ///< bᵢ

  static HWY_INLINE PrincipalFrame of_edges(Tag tag, const Columns<Vec>& e,
                                            const Symmetric<Vec>& g) {
    const Columns<Vec> l = cholesky(tag, g);
    Columns<Vec> el;
    product_of(e, l, el);
    Symmetric<Vec> c;
    metric(el, c);
    return PrincipalFrame(l, refined(of(c), el));
  }
  /// From a metric c of edges, which is that of B = e L pushed to Lᵀ c L.
  static HWY_INLINE PrincipalFrame of_metric(Tag, const Symmetric<Vec>& c, const Columns<Vec>& l) {
    Columns<Vec> cl;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        cl.m[j][i] = hn::MulAdd(c(i, 2), l.m[j][2],
                                hn::MulAdd(c(i, 1), l.m[j][1], hn::Mul(c(i, 0), l.m[j][0])));
      }
    }
    Symmetric<Vec> pushed;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        pushed(i, j) =
            hn::MulAdd(l.m[i][2], cl.m[j][2],
                       hn::MulAdd(l.m[i][1], cl.m[j][1], hn::Mul(l.m[i][0], cl.m[j][0])));
      }
    }
    return PrincipalFrame(l, refined(of(pushed), pushed));
  }

  /// result = factor Σ sᵢ bᵢ ⊗ bᵢ.
  HWY_INLINE void stress(const Real* s, Real factor, Symmetric<Vec>& result) const {
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        Vec sum = hn::Mul(hn::Mul(s[0].v, b.m[0][i]), b.m[0][j]);
        sum = hn::MulAdd(hn::Mul(s[1].v, b.m[1][i]), b.m[1][j], sum);
        sum = hn::MulAdd(hn::Mul(s[2].v, b.m[2][i]), b.m[2][j], sum);
        result(i, j) = hn::Mul(factor.v, sum);
      }
    }
  }

 private:
  HWY_INLINE PrincipalFrame(const Columns<Vec>& l, const Stretches<Real>& of_edges)
      : stretches(of_edges) {
    for (int i = 0; i < 3; ++i) {
      const Real* n = stretches.axes[i];
      for (int k = 0; k < 3; ++k) {
        Vec sum = hn::Mul(l.m[0][k], n[0].v);
        for (int j = 1; j <= k; ++j) sum = hn::MulAdd(l.m[j][k], n[j].v, sum);
        b.m[i][k] = sum;
      }
    }
  }

  // The stretches with all their digits where they are uneven. `source` is B or BᵀB. Copies are passed, so that the
  // compiler can keep the originals in registers.
  template <class Source>
  static HWY_INLINE Stretches<Real> refined(Stretches<Real> plain, const Source& source) {
    if (HWY_UNLIKELY(plain.is_uneven())) {
      const Source copy = source;
      Stretches<Real> exact = plain;
      refine(copy, exact);
      plain = exact;
    }
    return plain;
  }
  static HWY_NOINLINE void refine(const Columns<Vec>& of_b, Stretches<Real>& stretches) {
    Real columns[3][3];
    for (int k = 0; k < 9; ++k) columns[k / 3][k % 3] = Real(of_b.m[k / 3][k % 3]);
    stretches.refine(columns);
  }
  // The transposed Cholesky factor stands for B.
  static HWY_NOINLINE void refine(const Symmetric<Vec>& c, Stretches<Real>& stretches) {
    const Columns<Vec> factor = cholesky(Tag(), c);
    Real columns[3][3];
    for (int k = 0; k < 9; ++k) columns[k / 3][k % 3] = Real(factor.m[k % 3][k / 3]);
    stretches.refine(columns);
  }
  static HWY_INLINE Stretches<Real> of(const Symmetric<Vec>& c) {
    Real a[6];
    for (int k = 0; k < 6; ++k) a[k] = Real(c.m[k]);
    for (const int k : {0, 3, 5}) a[k] = a[k] - Real(1.0);
    return Stretches<Real>(a);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
