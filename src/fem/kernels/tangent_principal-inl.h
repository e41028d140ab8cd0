// The terms of laws in principal stretches in the tangent kernels. Highway includes this file once for each
// instruction set.
#if defined(TETRACTION_FEM_TANGENT_PRINCIPAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_TANGENT_PRINCIPAL_INL_H_
#undef TETRACTION_FEM_TANGENT_PRINCIPAL_INL_H_
#else
#define TETRACTION_FEM_TANGENT_PRINCIPAL_INL_H_
#endif

#include "material/laws/laws-inl.h"
#include "principal-inl.h"
#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using DoubleTag = hn::CappedTag<double, 8>;
using DoubleVec = hn::Vec<DoubleTag>;

HWY_INLINE void store_number(DoubleVec v, double* to) {
  hn::Store(v, DoubleTag(), to);
}
HWY_INLINE void store_number(DoubleVec v, float* to) {
  const hn::Rebind<float, DoubleTag> tag;
  hn::Store(hn::DemoteTo(tag, v), tag, to);
}

// Writes the numbers of the state of the elements in the lanes, one after the other.
template <class T>
class StateWriter {
 public:
  explicit StateWriter(T* state) : next_(state) {}
  HWY_INLINE void put(DoubleVec v) {
    store_number(v, next_);
    next_ += kBatchLanes;
  }

 private:
  T* next_;
};

template <class Vec>
HWY_INLINE Vec dot(const Vec* a, const Vec* b) {
  return hn::MulAdd(a[2], b[2], hn::MulAdd(a[1], b[1], hn::Mul(a[0], b[0])));
}

// The derivatives of a law. A law in principal stretches has those of its volumetric part here, and those of the
// isochoric one in principal_terms().
template <class M, class P, class Real>
HWY_INLINE auto first_derivatives(const P& material, const Invariants<Real>& s) {
  if constexpr (TermsOf<M>::kPrincipal) {
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    return FirstDerivatives{Real(0.0), Zero(), Real(material.kappa) * volumetric.first_derivative};
  } else {
    return Law<M>::first_derivatives(material, s);
  }
}
template <class M, class P, class Real>
HWY_INLINE auto second_derivatives(const P& material, const Invariants<Real>& s) {
  if constexpr (TermsOf<M>::kPrincipal) {
    const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
    return SecondDerivatives{Zero(), Zero(), Zero(),
                             Zero(), Zero(), Real(material.kappa) * volumetric.second_derivative};
  } else {
    return Law<M>::second_derivatives(material, s);
  }
}

// S and the principal terms of a state.
struct PrincipalTerms {
  using Real = Number<DoubleTag>;
  Symmetric<DoubleVec> stress;
  Columns<DoubleVec> y;
  Columns<DoubleVec> b;
  PrincipalTangent<Real> tangent;
  Real volume;

  // A constructor that the compiler makes by itself would not belong to the instruction set.
  HWY_INLINE PrincipalTerms() {}  // NOLINT(modernize-use-equals-default)

  template <class T>
  HWY_INLINE void write(StateWriter<T>& writer) const {
    for (int k = 0; k < 9; ++k) writer.put(y.m[k / 3][k % 3]);
    for (int k = 0; k < 9; ++k) writer.put(b.m[k / 3][k % 3]);
    for (const Real& theta : tangent.theta) writer.put((volume * theta).v);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) writer.put((volume * tangent.h[i][j]).v);
    }
  }
};
template <class M, class P>
HWY_INLINE auto principal_terms(DoubleTag tag, const P& material, const Columns<DoubleVec>& e,
                                const Symmetric<DoubleVec>& vg, DoubleVec inverse_volume,
                                Number<DoubleTag> volume) {
  if constexpr (TermsOf<M>::kPrincipal) {
    using Real = Number<DoubleTag>;
    Symmetric<DoubleVec> g;
    for (int k = 0; k < 6; ++k) g.m[k] = hn::Mul(vg.m[k], inverse_volume);
    const auto frame = PrincipalFrame<DoubleTag>::of_edges(tag, e, g);
    PrincipalTerms terms;
    terms.volume = volume;
    terms.b = frame.b;
    product_of(e, frame.b, terms.y);
    Real s[3];
    frame.stretches.template stress<Law<M>>(material, s);
    frame.stress(s, volume, terms.stress);
    terms.tangent = PrincipalTangent<Real>::template of<Law<M>>(material, frame.stretches);
    return terms;
  } else {
    return Zero();
  }
}

// Adds Σ S'ᵢⱼ yᵢ bⱼᵀ to the force.
template <class LoadedState, class Vec>
HWY_INLINE void add_principal(const LoadedState& s, const Columns<Vec>& de, Columns<Vec>& force) {
  Columns<Vec> u;  // de bᵢ
  product_of(de, s.b_i, u);
  Vec along[3];  // bᵢᵀ dc bᵢ
  for (int i = 0; i < 3; ++i) {
    const Vec half = dot(u.m[i], s.y_i.m[i]);
    along[i] = hn::Add(half, half);
  }
  Columns<Vec> f;  // Σᵢ S'ᵢⱼ yᵢ
  for (int j = 0; j < 3; ++j) {
    const auto& h = s.principal.h[j];
    const Vec own =
        hn::MulAdd(h[2].v, along[2], hn::MulAdd(h[1].v, along[1], hn::Mul(h[0].v, along[0])));
    for (int r = 0; r < 3; ++r) f.m[j][r] = hn::Mul(own, s.y_i.m[j][r]);
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    const Vec between = hn::Add(dot(u.m[i], s.y_i.m[j]), dot(u.m[j], s.y_i.m[i]));
    const Vec change = hn::Mul(s.principal.theta[k].v, between);
    for (int r = 0; r < 3; ++r) {
      f.m[j][r] = hn::MulAdd(change, s.y_i.m[i][r], f.m[j][r]);
      f.m[i][r] = hn::MulAdd(change, s.y_i.m[j][r], f.m[i][r]);
    }
  }
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 3; ++k) {
      for (int r = 0; r < 3; ++r) {
        force.m[k][r] = hn::MulAdd(f.m[j][r], s.b_i.m[j][k], force.m[k][r]);
      }
    }
  }
}

// The entry (r, c) of Σ out[i][j] yᵢ ⊗ yⱼ.
template <class Vec, class Real>
HWY_INLINE Vec entry_of(const Real (*out)[3], const Columns<Vec>& y, int r, int c, Vec sum) {
  for (int i = 0; i < 3; ++i) {
    const Vec row = hn::MulAdd(out[i][2].v, y.m[2][c],
                               hn::MulAdd(out[i][1].v, y.m[1][c], hn::Mul(out[i][0].v, y.m[0][c])));
    sum = hn::MulAdd(y.m[i][r], row, sum);
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
