// Moves records of four numbers (x y z 0 of a vertex) to lanes and back, for all vector lengths.
// Included by Highway once per instruction set.
#if defined(TETRACTION_FEM_SIMD_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_SIMD_ROWS_INL_H_
#undef TETRACTION_FEM_SIMD_ROWS_INL_H_
#else
#define TETRACTION_FEM_SIMD_ROWS_INL_H_
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <cstddef>
#include <cstdint>

#include "element_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Columns of a 3 × 3 matrix, or the coordinates of three edges: m[column][component].
template <class V>
struct Columns {
  V m[3][3];
};

/// A symmetric 3 × 3 matrix: 00 01 02 11 12 22.
template <class V>
struct Symmetric {
  V m[6];
  static constexpr int at(int i, int j) {
    constexpr int kPlace[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return kPlace[i][j];
  }
  const V& operator()(int i, int j) const { return m[at(i, j)]; }
  V& operator()(int i, int j) { return m[at(i, j)]; }
};

/// Reads records of `rows` and adds to them. `slots[a * stride + lane]` is the slot of node a of
/// the element in a lane: where its record begins, counted in numbers.
#if HWY_TARGET == HWY_SCALAR
template <class D>
class RecordAccess {
 public:
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;

  /// e[k] = record of node k + 1 less record of node 0.
  static void edges(D d, const T* rows, const uint16_t* slots, size_t stride, Columns<V>& e) {
    edges<false>(d, rows, nullptr, slots, stride, e);
  }
  /// The same of rows + changes, part by part.
  template <bool kChanges>
  static void edges(D d, const T* rows, const T* changes, const uint16_t* slots, size_t stride,
                    Columns<V>& e) {
    for (size_t k = 0; k < 3; ++k) {
      const uint16_t node = slots[(k + 1) * stride];
      for (size_t i = 0; i < 3; ++i) {
        T edge = rows[node + i] - rows[slots[0] + i];
        if constexpr (kChanges) edge += changes[node + i] - changes[slots[0] + i];
        e.m[k][i] = hn::Set(d, edge);
      }
    }
  }

  /// Adds f[k] to the record of node k + 1 and subtracts it from that of node 0.
  static void add_balanced(D, const Columns<V>& f, T* rows, const uint16_t* slots, size_t stride) {
    for (size_t i = 0; i < 3; ++i) {
      T sum = 0;
      for (size_t k = 0; k < 3; ++k) {
        const T value = hn::GetLane(f.m[k][i]);
        rows[slots[(k + 1) * stride] + i] += value;
        sum += value;
      }
      rows[slots[0] + i] -= sum;
    }
  }
};
#else
template <class D>
class RecordAccess {
 public:
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;
  static constexpr size_t kLanes = hn::MaxLanes(D());

  /// e[k] = record of node k + 1 less record of node 0.
  static HWY_INLINE void edges(D d, const T* HWY_RESTRICT rows, const uint16_t* HWY_RESTRICT slots,
                               size_t stride, Columns<V>& e) {
    edges<false>(d, rows, nullptr, slots, stride, e);
  }
  /// The same of rows + changes, part by part.
  template <bool kChanges>
  static HWY_INLINE void edges(D d, const T* HWY_RESTRICT rows, const T* HWY_RESTRICT changes,
                               const uint16_t* HWY_RESTRICT slots, size_t stride, Columns<V>& e) {
    for (size_t k = 0; k < 3; ++k) {
      const uint16_t* node = slots + (k + 1) * stride;
      if constexpr (sizeof(T) * kLanes == 16 && sizeof(T) == 8) {
        const auto part = [&](size_t lane, size_t half) HWY_ATTR {
          const size_t to = node[lane] + half;
          const size_t from = slots[lane] + half;
          V edge = hn::Sub(hn::Load(d, rows + to), hn::Load(d, rows + from));
          if constexpr (kChanges) {
            edge = hn::Add(edge, hn::Sub(hn::Load(d, changes + to), hn::Load(d, changes + from)));
          }
          return edge;
        };
        const V low0 = part(0, 0);
        const V low1 = part(1, 0);
        e.m[k][0] = hn::InterleaveLower(d, low0, low1);
        e.m[k][1] = hn::InterleaveUpper(d, low0, low1);
        e.m[k][2] = hn::InterleaveLower(d, part(0, 2), part(1, 2));
      } else {
        const V a = difference<0, kChanges>(d, rows, changes, node, slots);
        const V b = difference<1, kChanges>(d, rows, changes, node, slots);
        const V c = difference<2, kChanges>(d, rows, changes, node, slots);
        const V f = difference<3, kChanges>(d, rows, changes, node, slots);
        transpose(d, a, b, c, f, e.m[k]);
      }
    }
  }

  /// Adds f[k] to the records of node k + 1 and subtracts it from those of node 0.
  static HWY_INLINE void add_balanced(D d, const Columns<V>& f, T* HWY_RESTRICT rows,
                                      const uint16_t* HWY_RESTRICT slots, size_t stride) {
    if constexpr (sizeof(T) * kLanes == 16 && sizeof(T) == 8) {
      const V zero = hn::Zero(d);
      V sum[4] = {zero, zero, zero, zero};
      for (size_t k = 0; k < 3; ++k) {
        const uint16_t* node = slots + (k + 1) * stride;
        const V part[4] = {
            hn::InterleaveLower(d, f.m[k][0], f.m[k][1]), hn::InterleaveLower(d, f.m[k][2], zero),
            hn::InterleaveUpper(d, f.m[k][0], f.m[k][1]), hn::InterleaveUpper(d, f.m[k][2], zero)};
        for (size_t i = 0; i < 4; ++i) {
          add(d, part[i], rows + node[i / 2] + 2 * (i % 2));
          sum[i] = hn::Add(sum[i], part[i]);
        }
      }
      for (size_t i = 0; i < 4; ++i) {
        T* row = rows + slots[i / 2] + 2 * (i % 2);
        hn::Store(hn::Sub(hn::Load(d, row), sum[i]), d, row);
      }
    } else {
      V total[4];
      for (size_t k = 0; k < 3; ++k) {
        const uint16_t* node = slots + (k + 1) * stride;
        V r[4];
        transpose_back(d, f.m[k], r);
        for (size_t i = 0; i < 4; ++i) total[i] = k == 0 ? r[i] : hn::Add(total[i], r[i]);
        scatter<0>(d, r[0], rows, node);
        scatter<1>(d, r[1], rows, node);
        scatter<2>(d, r[2], rows, node);
        scatter<3>(d, r[3], rows, node);
      }
      for (V& v : total) v = hn::Neg(v);
      scatter<0>(d, total[0], rows, slots);
      scatter<1>(d, total[1], rows, slots);
      scatter<2>(d, total[2], rows, slots);
      scatter<3>(d, total[3], rows, slots);
    }
  }

 private:
  using R = hn::CappedTag<T, 4>;               // holds one record
  static constexpr size_t kRows = kLanes / 4;  // records in a vector

  template <class D2>
  static HWY_INLINE void add(D2 d, hn::Vec<D2> v, T* row) {
    hn::Store(hn::Add(hn::Load(d, row), v), d, row);
  }

  // Lane of the element whose record is at `place` in vector `i` of four. Doubles are transposed in
  // blocks of two, floats in blocks of four.
  static constexpr size_t lane_of(size_t i, size_t place) { return i + 4 * place; }

  static HWY_INLINE hn::Vec<R> row_difference(const T* rows, uint16_t node, uint16_t origin) {
    const R r;
    return hn::Sub(hn::Load(r, rows + node), hn::Load(r, rows + origin));
  }

  template <size_t I, bool kChanges>
  static HWY_INLINE V difference(D d, const T* HWY_RESTRICT rows, const T* HWY_RESTRICT changes,
                                 const uint16_t* node, const uint16_t* origin) {
    (void)d;
    const auto at = [&](size_t place) HWY_ATTR {
      const size_t lane = lane_of(I, place);
      const auto edge = row_difference(rows, node[lane], origin[lane]);
      if constexpr (kChanges) {
        return hn::Add(edge, row_difference(changes, node[lane], origin[lane]));
      } else {
        return edge;
      }
    };
    if constexpr (kRows == 1) {
      return at(0);
    } else if constexpr (kRows == 2) {
      return hn::Combine(d, at(1), at(0));
    } else {
      const hn::Half<D> h;
      return hn::Combine(d, hn::Combine(h, at(3), at(2)), hn::Combine(h, at(1), at(0)));
    }
  }

  template <size_t I>
  static HWY_INLINE void scatter(D d, V v, T* HWY_RESTRICT rows, const uint16_t* node) {
    const R r;
    (void)d;
    if constexpr (kRows == 1) {
      add(r, v, rows + node[lane_of(I, 0)]);
    } else if constexpr (kRows == 2) {
      add(r, hn::LowerHalf(r, v), rows + node[lane_of(I, 0)]);
      add(r, hn::UpperHalf(r, v), rows + node[lane_of(I, 1)]);
    } else {
      const hn::Half<D> h;
      const auto low = hn::LowerHalf(h, v);
      const auto high = hn::UpperHalf(h, v);
      add(r, hn::LowerHalf(r, low), rows + node[lane_of(I, 0)]);
      add(r, hn::UpperHalf(r, low), rows + node[lane_of(I, 1)]);
      add(r, hn::LowerHalf(r, high), rows + node[lane_of(I, 2)]);
      add(r, hn::UpperHalf(r, high), rows + node[lane_of(I, 3)]);
    }
  }

  static HWY_INLINE void transpose(D d, V a, V b, V c, V f, V* x) {
    if constexpr (sizeof(T) == 8) {
      const V ab_low = hn::InterleaveLower(d, a, b);
      const V ab_high = hn::InterleaveUpper(d, a, b);
      const V cf_low = hn::InterleaveLower(d, c, f);
      const V cf_high = hn::InterleaveUpper(d, c, f);
      x[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(cf_low), ab_low);
      x[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(cf_high), ab_high);
      x[2] = hn::OddEvenBlocks(cf_low, hn::SwapAdjacentBlocks(ab_low));
    } else {
      const hn::RepartitionToWide<D> w;
      const auto ab_low = hn::BitCast(w, hn::InterleaveLower(d, a, b));
      const auto ab_high = hn::BitCast(w, hn::InterleaveUpper(d, a, b));
      const auto cf_low = hn::BitCast(w, hn::InterleaveLower(d, c, f));
      const auto cf_high = hn::BitCast(w, hn::InterleaveUpper(d, c, f));
      x[0] = hn::BitCast(d, hn::InterleaveLower(w, ab_low, cf_low));
      x[1] = hn::BitCast(d, hn::InterleaveUpper(w, ab_low, cf_low));
      x[2] = hn::BitCast(d, hn::InterleaveLower(w, ab_high, cf_high));
    }
  }

  static HWY_INLINE void transpose_back(D d, const V* x, V* r) {
    const V zero = hn::Zero(d);
    const V xy_low = hn::InterleaveLower(d, x[0], x[1]);
    const V xy_high = hn::InterleaveUpper(d, x[0], x[1]);
    const V z_low = hn::InterleaveLower(d, x[2], zero);
    const V z_high = hn::InterleaveUpper(d, x[2], zero);
    if constexpr (sizeof(T) == 8) {
      r[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(z_low), xy_low);
      r[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(z_high), xy_high);
      r[2] = hn::OddEvenBlocks(z_low, hn::SwapAdjacentBlocks(xy_low));
      r[3] = hn::OddEvenBlocks(z_high, hn::SwapAdjacentBlocks(xy_high));
    } else {
      const hn::RepartitionToWide<D> w;
      const auto low = hn::BitCast(w, xy_low);
      const auto high = hn::BitCast(w, xy_high);
      const auto zl = hn::BitCast(w, z_low);
      const auto zh = hn::BitCast(w, z_high);
      r[0] = hn::BitCast(d, hn::InterleaveLower(w, low, zl));
      r[1] = hn::BitCast(d, hn::InterleaveUpper(w, low, zl));
      r[2] = hn::BitCast(d, hn::InterleaveLower(w, high, zh));
      r[3] = hn::BitCast(d, hn::InterleaveUpper(w, high, zh));
    }
  }
};

#endif

/// w.m[k] = cofactor of column k of e (the cross product of the other two); returns det e.
template <class V>
HWY_INLINE V cofactors(const Columns<V>& e, Columns<V>& w) {
  for (int k = 0; k < 3; ++k) {
    const V* a = e.m[(k + 1) % 3];
    const V* b = e.m[(k + 2) % 3];
    for (int i = 0; i < 3; ++i) {
      const int p = (i + 1) % 3;
      const int q = (i + 2) % 3;
      w.m[k][i] = hn::MulSub(a[p], b[q], hn::Mul(a[q], b[p]));
    }
  }
  return hn::MulAdd(e.m[0][0], w.m[0][0],
                    hn::MulAdd(e.m[0][1], w.m[0][1], hn::Mul(e.m[0][2], w.m[0][2])));
}

/// How many batches ahead data is fetched from memory.
constexpr size_t kAhead = 3;

/// Prefetches `count` numbers that will be needed soon. `data` may lie behind the end of an array.
template <class T>
HWY_INLINE void prefetch(const T* data, size_t count) {
  const char* line = reinterpret_cast<const char*>(data);
  for (const char* end = line + count * sizeof(T); line < end; line += 64) hwy::Prefetch(line);
}

// Marks the body of for_each_vector(). The body must be inlined into its loop, because a call for
// every vector would cost a tenth of the time.
#undef TETRACTION_LOOP_BODY
#define TETRACTION_LOOP_BODY HWY_ATTR __attribute__((always_inline))

/// The loop over the elements of a block. It calls body(batch, lane, rest, slots) for the vectors
/// of every batch, kTogether vectors at a time; `rest` and `slots` are the data of the first lane.
/// It also calls ahead(batch) once for every batch, which prefetches what will be needed soon.
template <class D, size_t kTogether = 1, class Ahead, class Body>
HWY_INLINE void for_each_vector(const BatchView& batches, const Ahead& ahead, const Body& body) {
  const double* HWY_RESTRICT rest = batches.rest;
  const uint16_t* HWY_RESTRICT slots = batches.slots;
  for (size_t b = 0; b < static_cast<size_t>(batches.count); ++b) {
    ahead(b);
    prefetch(slots + kAhead * 4 * kBatchLanes, 4 * kBatchLanes);
    for (size_t lane = 0; lane < kBatchLanes; lane += kTogether * hn::MaxLanes(D())) {
      body(b, lane, rest + lane, slots + lane);
    }
    rest += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
  }
}
/// The same loop for a body that reads the rest data, which are prefetched.
template <class D, size_t kTogether = 1, class Body>
HWY_INLINE void for_each_vector(const BatchView& batches, const Body& body) {
  const auto ahead = [&](size_t b) HWY_ATTR {
    prefetch(batches.rest + (b + kAhead) * kRestNumbers * kBatchLanes, kRestNumbers * kBatchLanes);
  };
  for_each_vector<D, kTogether>(batches, ahead, body);
}

/// ln j and 1/j. Near 1, where volumes nearly always are, ln j = 2 artanh s with s = (j − 1)/(j +
/// 1), accurate relative to ln j itself, and one division gives both.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V log_and_inverse(D d, V j, V& inverse) {
  const V one = hn::Set(d, 1.0);
  const V above = hn::Add(j, one);
  const V r = hn::Div(one, hn::Mul(j, above));
  inverse = hn::Mul(r, above);
  const V s = hn::Mul(hn::Sub(j, one), hn::Mul(r, j));
  // |s| ≤ 1/6: the next term of the series is below 1e-18.
  if (HWY_UNLIKELY(!hn::AllTrue(d, hn::Le(hn::Abs(s), hn::Set(d, 1.0 / 6.0))))) {
    return hn::Log(d, j);
  }
  const V x = hn::Mul(s, s);
  const V x2 = hn::Mul(x, x);
  const auto pair = [&](int k) HWY_ATTR {  // terms k and k + 1
    return hn::MulAdd(hn::Set(d, 2.0 / (2 * k + 3)), x, hn::Set(d, 2.0 / (2 * k + 1)));
  };
  const V low = hn::MulAdd(pair(2), x2, pair(0));
  const V middle = hn::MulAdd(pair(6), x2, pair(4));
  const V high = hn::MulAdd(hn::Set(d, 2.0 / 21), x2, pair(8));
  const V x4 = hn::Mul(x2, x2);
  return hn::Mul(s, hn::MulAdd(hn::MulAdd(high, x4, middle), x4, low));
}

/// e s, s symmetric.
template <class V>
HWY_INLINE void multiply(const Columns<V>& e, const Symmetric<V>& s, Columns<V>& result) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      result.m[j][i] = hn::MulAdd(e.m[2][i], s(2, j),
                                  hn::MulAdd(e.m[1][i], s(1, j), hn::Mul(e.m[0][i], s(0, j))));
    }
  }
}

/// eᵀe.
template <class V>
HWY_INLINE void metric(const Columns<V>& e, Symmetric<V>& c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      c(i, j) = hn::MulAdd(e.m[i][2], e.m[j][2],
                           hn::MulAdd(e.m[i][1], e.m[j][1], hn::Mul(e.m[i][0], e.m[j][0])));
    }
  }
}

/// a b, both symmetric.
template <class V>
HWY_INLINE void symmetric_times(const Symmetric<V>& a, const Symmetric<V>& b, Columns<V>& r) {
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      r.m[j][i] =
          hn::MulAdd(a(i, 2), b(2, j), hn::MulAdd(a(i, 1), b(1, j), hn::Mul(a(i, 0), b(0, j))));
    }
  }
}

/// a b with a symmetric, where the product is known to be symmetric, too.
template <class V>
HWY_INLINE void symmetric_product(const Symmetric<V>& a, const Columns<V>& b, Symmetric<V>& r) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      r(i, j) = hn::MulAdd(a(i, 2), b.m[j][2],
                           hn::MulAdd(a(i, 1), b.m[j][1], hn::Mul(a(i, 0), b.m[j][0])));
    }
  }
}

/// tr(m²).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V trace_of_square(D d, const Columns<V>& m) {
  const V off = hn::MulAdd(m.m[0][1], m.m[1][0],
                           hn::MulAdd(m.m[0][2], m.m[2][0], hn::Mul(m.m[1][2], m.m[2][1])));
  const V on = hn::MulAdd(m.m[0][0], m.m[0][0],
                          hn::MulAdd(m.m[1][1], m.m[1][1], hn::Mul(m.m[2][2], m.m[2][2])));
  return hn::MulAdd(hn::Set(d, 2.0), off, on);
}

/// Σ of the kBatchLanes numbers of a batch, lane by lane: the same order of additions for every
/// vector length.
template <class D, class V = hn::Vec<D>>
HWY_INLINE double sum_of_lanes(D d, const V* sums) {
  constexpr size_t kLanes = hn::MaxLanes(D());
  HWY_ALIGN double lanes[kBatchLanes];
  for (size_t i = 0; i < kBatchLanes / kLanes; ++i) hn::Store(sums[i], d, lanes + i * kLanes);
  double total = 0.0;
  for (const double lane : lanes) total += lane;
  return total;
}

/// a:b = Σ a_ij b_ij.
template <class V>
HWY_INLINE V contract(const Columns<V>& a, const Columns<V>& b) {
  V sum = hn::Mul(a.m[0][0], b.m[0][0]);
  for (int k = 1; k < 9; ++k) {
    sum = hn::MulAdd(a.m[k / 3][k % 3], b.m[k / 3][k % 3], sum);
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
