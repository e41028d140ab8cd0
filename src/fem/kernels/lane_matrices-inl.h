// 3 × 3 matrices in the lanes of vectors. Highway includes this file once for each instruction set.
#if defined(TETRACTION_FEM_LANE_MATRICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_LANE_MATRICES_INL_H_
#undef TETRACTION_FEM_LANE_MATRICES_INL_H_
#else
#define TETRACTION_FEM_LANE_MATRICES_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A 3 × 3 matrix in every lane, for instance three edges as columns: m[column][component].
template <class Vec>
struct Columns {
  Vec m[3][3];
};

/// A symmetric 3 × 3 matrix in every lane: the entries 00 01 02 11 12 22.
template <class Vec>
struct Symmetric {
  Vec m[6];
  static constexpr int at(int i, int j) {
    constexpr int kPlace[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return kPlace[i][j];
  }
  const Vec& operator()(int i, int j) const { return m[at(i, j)]; }
  Vec& operator()(int i, int j) { return m[at(i, j)]; }
};

/// Column k of w is the cross product of the other two columns of e: w is the cofactor matrix of e.
/// Returns det e.
template <class Vec>
HWY_INLINE Vec cofactors(const Columns<Vec>& e, Columns<Vec>& w) {
  for (int k = 0; k < 3; ++k) {
    const Vec* a = e.m[(k + 1) % 3];
    const Vec* b = e.m[(k + 2) % 3];
    for (int i = 0; i < 3; ++i) {
      const int p = (i + 1) % 3;
      const int q = (i + 2) % 3;
      w.m[k][i] = hn::MulSub(a[p], b[q], hn::Mul(a[q], b[p]));
    }
  }
  return hn::MulAdd(e.m[0][0], w.m[0][0],
                    hn::MulAdd(e.m[0][1], w.m[0][1], hn::Mul(e.m[0][2], w.m[0][2])));
}

/// result = e s with a symmetric s.
template <class Vec>
HWY_INLINE void multiply(const Columns<Vec>& e, const Symmetric<Vec>& s, Columns<Vec>& result) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      result.m[j][i] = hn::MulAdd(e.m[2][i], s(2, j),
                                  hn::MulAdd(e.m[1][i], s(1, j), hn::Mul(e.m[0][i], s(0, j))));
    }
  }
}

/// c = eᵀe.
template <class Vec>
HWY_INLINE void metric(const Columns<Vec>& e, Symmetric<Vec>& c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      c(i, j) = hn::MulAdd(e.m[i][2], e.m[j][2],
                           hn::MulAdd(e.m[i][1], e.m[j][1], hn::Mul(e.m[i][0], e.m[j][0])));
    }
  }
}

/// result = a b with symmetric a and b.
template <class Vec>
HWY_INLINE void symmetric_times(const Symmetric<Vec>& a, const Symmetric<Vec>& b,
                                Columns<Vec>& result) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      result.m[j][i] =
          hn::MulAdd(a(i, 2), b(2, j), hn::MulAdd(a(i, 1), b(1, j), hn::Mul(a(i, 0), b(0, j))));
    }
  }
}

/// result = a b with a symmetric a, if the product is known to be symmetric.
template <class Vec>
HWY_INLINE void symmetric_product(const Symmetric<Vec>& a, const Columns<Vec>& b,
                                  Symmetric<Vec>& result) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      result(i, j) = hn::MulAdd(a(i, 2), b.m[j][2],
                                hn::MulAdd(a(i, 1), b.m[j][1], hn::Mul(a(i, 0), b.m[j][0])));
    }
  }
}

/// tr(m²).
template <class Tag, class Vec = hn::Vec<Tag>>
HWY_INLINE Vec trace_of_square(Tag tag, const Columns<Vec>& m) {
  const Vec off = hn::MulAdd(m.m[0][1], m.m[1][0],
                             hn::MulAdd(m.m[0][2], m.m[2][0], hn::Mul(m.m[1][2], m.m[2][1])));
  const Vec on = hn::MulAdd(m.m[0][0], m.m[0][0],
                            hn::MulAdd(m.m[1][1], m.m[1][1], hn::Mul(m.m[2][2], m.m[2][2])));
  return hn::MulAdd(hn::Set(tag, 2.0), off, on);
}

/// result = aᵀb + bᵀa.
template <class Vec>
HWY_INLINE void symmetric_sum(const Columns<Vec>& a, const Columns<Vec>& b,
                              Symmetric<Vec>& result) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Vec sum = hn::Mul(a.m[i][0], b.m[j][0]);
      sum = hn::MulAdd(a.m[j][0], b.m[i][0], sum);
      for (int k = 1; k < 3; ++k) {
        sum = hn::MulAdd(a.m[i][k], b.m[j][k], sum);
        sum = hn::MulAdd(a.m[j][k], b.m[i][k], sum);
      }
      result(i, j) = sum;
    }
  }
}

/// a:b = Σ a_ij b_ij.
template <class Vec>
HWY_INLINE Vec contract(const Columns<Vec>& a, const Columns<Vec>& b) {
  Vec sum = hn::Mul(a.m[0][0], b.m[0][0]);
  for (int k = 1; k < 9; ++k) {
    sum = hn::MulAdd(a.m[k / 3][k % 3], b.m[k / 3][k % 3], sum);
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
