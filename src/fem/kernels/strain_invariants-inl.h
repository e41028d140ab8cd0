// Strain invariants in the lanes that keep their digits near rest and far from it. Highway includes this file
// once for each instruction set.
#if defined(TETRACTION_FEM_STRAIN_INVARIANTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_STRAIN_INVARIANTS_INL_H_
#undef TETRACTION_FEM_STRAIN_INVARIANTS_INL_H_
#else
#define TETRACTION_FEM_STRAIN_INVARIANTS_INL_H_
#endif

#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Tag = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Tag>;

// ag = a G = c G − I, computed so that it is accurate near rest.
HWY_INLINE void strain(Tag tag, const Symmetric<Vec>& c, const Symmetric<Vec>& vg,
                       Vec inverse_volume, Columns<Vec>& ag) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec sum =
          hn::MulAdd(c(i, 2), vg(2, j), hn::MulAdd(c(i, 1), vg(1, j), hn::Mul(c(i, 0), vg(0, j))));
      ag.m[j][i] = i == j ? hn::MulSub(sum, inverse_volume, hn::Set(tag, 1.0))
                          : hn::Mul(sum, inverse_volume);
    }
  }
}

HWY_INLINE Vec trace(const Columns<Vec>& m) {
  return hn::Add(m.m[0][0], hn::Add(m.m[1][1], m.m[2][2]));
}

// Below this value of I₁ − 3 − 2 ln J (strains of 3e-3) its plain formula loses too many digits.
constexpr double kSmallStrain = 1e-5;

// Replaces i1_term = I₁ − 3 − 2 ln J and i2_term = I₂ − 3 − 4 ln J by values without cancellation in the lanes where
// the strain is small. With the invariants II and III of A = c G − I and x = J² − 1 = tr A + II + III they are
//
//     x − 2 ln J − II − III,   2 (x − 2 ln J) − II − 2 III
//
// (material/strain_invariants.h). cvg = c V G; the invariants are those of V A.
template <bool kSecond>
HWY_INLINE void refine(Tag tag, const Columns<Vec>& cvg, Vec volume, Vec inverse_volume, Vec j,
                       Vec log_j, Vec& i1_term, Vec& i2_term) {
  const Vec one = hn::Set(tag, 1.0);
  const auto& m = cvg.m;
  const Vec m00 = hn::Sub(m[0][0], volume);
  const Vec m11 = hn::Sub(m[1][1], volume);
  const Vec m22 = hn::Sub(m[2][2], volume);
  const Vec w0 = hn::MulSub(m11, m22, hn::Mul(m[1][2], m[2][1]));
  const Vec w1 = hn::MulSub(m00, m22, hn::Mul(m[0][2], m[2][0]));
  const Vec w2 = hn::MulSub(m00, m11, hn::Mul(m[0][1], m[1][0]));
  const Vec x1 = hn::MulSub(m[2][1], m[0][2], hn::Mul(m[0][1], m22));
  const Vec x2 = hn::MulSub(m[0][1], m[1][2], hn::Mul(m[0][2], m11));
  const Vec det = hn::MulAdd(m00, w0, hn::MulAdd(m[1][0], x1, hn::Mul(m[2][0], x2)));
  const Vec square = hn::Mul(inverse_volume, inverse_volume);
  const Vec second = hn::Mul(hn::Add(w0, hn::Add(w1, w2)), square);
  const Vec third = hn::Mul(hn::Mul(det, inverse_volume), square);
  const Vec x = hn::Mul(hn::Sub(j, one), hn::Add(j, one));
  const Vec difference = hn::Sub(x, hn::Add(log_j, log_j));
  const auto small = hn::Lt(i1_term, hn::Set(tag, kSmallStrain));
  i1_term = hn::IfThenElse(small, hn::Sub(difference, hn::Add(second, third)), i1_term);
  if constexpr (kSecond) {
    const Vec value =
        hn::Sub(hn::Add(difference, difference), hn::Add(second, hn::Add(third, third)));
    i2_term = hn::IfThenElse(small, value, i2_term);
  }
}

// Above this value of I₁ the formula I₂ = ½ (I₁² − tr C²) loses too many digits.
constexpr double kLargeStretch = 1e3;

// I₂ = |cof F|² = cof(e)ᵀcof(e) : adj(V G)/V². It keeps its digits, because it is a sum of squares.
HWY_INLINE Vec second_invariant(const Columns<Vec>& cofactor, const Symmetric<Vec>& vg,
                                Vec inverse_volume) {
  Symmetric<Vec> w;
  metric(cofactor, w);
  Vec sum = hn::Mul(w(0, 0), hn::MulSub(vg(1, 1), vg(2, 2), hn::Mul(vg(1, 2), vg(1, 2))));
  sum = hn::MulAdd(w(1, 1), hn::MulSub(vg(0, 0), vg(2, 2), hn::Mul(vg(0, 2), vg(0, 2))), sum);
  sum = hn::MulAdd(w(2, 2), hn::MulSub(vg(0, 0), vg(1, 1), hn::Mul(vg(0, 1), vg(0, 1))), sum);
  Vec off = hn::Mul(w(0, 1), hn::MulSub(vg(0, 2), vg(1, 2), hn::Mul(vg(0, 1), vg(2, 2))));
  off = hn::MulAdd(w(0, 2), hn::MulSub(vg(0, 1), vg(1, 2), hn::Mul(vg(0, 2), vg(1, 1))), off);
  off = hn::MulAdd(w(1, 2), hn::MulSub(vg(0, 1), vg(0, 2), hn::Mul(vg(0, 0), vg(1, 2))), off);
  sum = hn::Add(sum, hn::Add(off, off));
  return hn::Mul(sum, hn::Mul(inverse_volume, inverse_volume));
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
