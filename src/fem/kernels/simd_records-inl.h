// Loads records of four numbers (x y z 0 of a vertex) into the lanes of vectors and adds lanes back
// to records, for all vector lengths. Highway includes this file once for each instruction set.
#if defined(TETRACTION_FEM_SIMD_RECORDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_SIMD_RECORDS_INL_H_
#undef TETRACTION_FEM_SIMD_RECORDS_INL_H_
#else
#define TETRACTION_FEM_SIMD_RECORDS_INL_H_
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <cstddef>
#include <cstdint>

#include "element_kernels.h"
#include "lane_matrices-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Reads vertex records and adds to them. slots[a * stride + lane] is the slot of node a of the
/// element in a lane: the index in `records` of the first number of the node's record.
#if HWY_TARGET == HWY_SCALAR
template <class Tag>
class RecordAccess {
 public:
  using T = hn::TFromD<Tag>;
  using Vec = hn::Vec<Tag>;

  /// Edges: e[k] = record of node k + 1 minus record of node 0.
  static void edges(Tag tag, const T* records, const uint16_t* slots, size_t stride,
                    Columns<Vec>& e) {
    edges<false>(tag, records, nullptr, slots, stride, e);
  }
  /// Edges of the sum records + displacements. The edges of both parts are formed separately and then
  /// added (tetraction/fem/positions.h).
  template <bool kHasDisplacements>
  static void edges(Tag tag, const T* records, const T* displacements, const uint16_t* slots,
                    size_t stride, Columns<Vec>& e) {
    for (size_t k = 0; k < 3; ++k) {
      const uint16_t node = slots[(k + 1) * stride];
      for (size_t i = 0; i < 3; ++i) {
        T edge = records[node + i] - records[slots[0] + i];
        if constexpr (kHasDisplacements)
          edge += displacements[node + i] - displacements[slots[0] + i];
        e.m[k][i] = hn::Set(tag, edge);
      }
    }
  }

  /// Adds f[k] to the record of node k + 1 and subtracts it from the record of node 0.
  static void add_balanced(Tag, const Columns<Vec>& f, T* records, const uint16_t* slots,
                           size_t stride) {
    for (size_t i = 0; i < 3; ++i) {
      T sum = 0;
      for (size_t k = 0; k < 3; ++k) {
        const T value = hn::GetLane(f.m[k][i]);
        records[slots[(k + 1) * stride] + i] += value;
        sum += value;
      }
      records[slots[0] + i] -= sum;
    }
  }
};
#else
template <class Tag>
class RecordAccess {
 public:
  using T = hn::TFromD<Tag>;
  using Vec = hn::Vec<Tag>;
  static constexpr size_t kLanes = hn::MaxLanes(Tag());

  /// Edges: e[k] = record of node k + 1 minus record of node 0.
  static HWY_INLINE void edges(Tag tag, const T* HWY_RESTRICT records,
                               const uint16_t* HWY_RESTRICT slots, size_t stride, Columns<Vec>& e) {
    edges<false>(tag, records, nullptr, slots, stride, e);
  }
  /// Edges of the sum records + displacements. The edges of both parts are formed separately and then
  /// added (tetraction/fem/positions.h).
  template <bool kHasDisplacements>
  static HWY_INLINE void edges(Tag tag, const T* HWY_RESTRICT records,
                               const T* HWY_RESTRICT displacements,
                               const uint16_t* HWY_RESTRICT slots, size_t stride, Columns<Vec>& e) {
    for (size_t k = 0; k < 3; ++k) {
      const uint16_t* node = slots + (k + 1) * stride;
      if constexpr (sizeof(T) * kLanes == 16 && sizeof(T) == 8) {
        const auto part = [&](size_t lane, size_t half) HWY_ATTR {
          const size_t to = node[lane] + half;
          const size_t from = slots[lane] + half;
          Vec edge = hn::Sub(hn::Load(tag, records + to), hn::Load(tag, records + from));
          if constexpr (kHasDisplacements) {
            edge = hn::Add(edge, hn::Sub(hn::Load(tag, displacements + to),
                                         hn::Load(tag, displacements + from)));
          }
          return edge;
        };
        const Vec low0 = part(0, 0);
        const Vec low1 = part(1, 0);
        e.m[k][0] = hn::InterleaveLower(tag, low0, low1);
        e.m[k][1] = hn::InterleaveUpper(tag, low0, low1);
        e.m[k][2] = hn::InterleaveLower(tag, part(0, 2), part(1, 2));
      } else {
        const Vec a = difference<0, kHasDisplacements>(tag, records, displacements, node, slots);
        const Vec b = difference<1, kHasDisplacements>(tag, records, displacements, node, slots);
        const Vec c = difference<2, kHasDisplacements>(tag, records, displacements, node, slots);
        const Vec f = difference<3, kHasDisplacements>(tag, records, displacements, node, slots);
        transpose(tag, a, b, c, f, e.m[k]);
      }
    }
  }

  /// Adds f[k] to the record of node k + 1 and subtracts it from the record of node 0.
  static HWY_INLINE void add_balanced(Tag tag, const Columns<Vec>& f, T* HWY_RESTRICT records,
                                      const uint16_t* HWY_RESTRICT slots, size_t stride) {
    if constexpr (sizeof(T) * kLanes == 16 && sizeof(T) == 8) {
      const Vec zero = hn::Zero(tag);
      Vec sum[4] = {zero, zero, zero, zero};
      for (size_t k = 0; k < 3; ++k) {
        const uint16_t* node = slots + (k + 1) * stride;
        const Vec part[4] = {hn::InterleaveLower(tag, f.m[k][0], f.m[k][1]),
                             hn::InterleaveLower(tag, f.m[k][2], zero),
                             hn::InterleaveUpper(tag, f.m[k][0], f.m[k][1]),
                             hn::InterleaveUpper(tag, f.m[k][2], zero)};
        for (size_t i = 0; i < 4; ++i) {
          add(tag, part[i], records + node[i / 2] + 2 * (i % 2));
          sum[i] = hn::Add(sum[i], part[i]);
        }
      }
      for (size_t i = 0; i < 4; ++i) {
        T* record = records + slots[i / 2] + 2 * (i % 2);
        hn::Store(hn::Sub(hn::Load(tag, record), sum[i]), tag, record);
      }
    } else {
      Vec total[4];
      for (size_t k = 0; k < 3; ++k) {
        const uint16_t* node = slots + (k + 1) * stride;
        Vec packed[4];
        transpose_back(tag, f.m[k], packed);
        for (size_t i = 0; i < 4; ++i) total[i] = k == 0 ? packed[i] : hn::Add(total[i], packed[i]);
        scatter<0>(tag, packed[0], records, node);
        scatter<1>(tag, packed[1], records, node);
        scatter<2>(tag, packed[2], records, node);
        scatter<3>(tag, packed[3], records, node);
      }
      for (Vec& v : total) v = hn::Neg(v);
      scatter<0>(tag, total[0], records, slots);
      scatter<1>(tag, total[1], records, slots);
      scatter<2>(tag, total[2], records, slots);
      scatter<3>(tag, total[3], records, slots);
    }
  }

 private:
  using RecordTag = hn::CappedTag<T, 4>;  // a vector of one record
  static constexpr size_t kRecordsPerVector = kLanes / 4;

  template <class AnyTag>
  static HWY_INLINE void add(AnyTag tag, hn::Vec<AnyTag> v, T* record) {
    hn::Store(hn::Add(hn::Load(tag, record), v), tag, record);
  }

  // The lane of the element whose record is number `place` in vector `i` of four.
  static constexpr size_t lane_of(size_t i, size_t place) { return i + 4 * place; }

  static HWY_INLINE hn::Vec<RecordTag> record_difference(const T* records, uint16_t node,
                                                         uint16_t origin) {
    const RecordTag record_tag;
    return hn::Sub(hn::Load(record_tag, records + node), hn::Load(record_tag, records + origin));
  }

  template <size_t I, bool kHasDisplacements>
  static HWY_INLINE Vec difference(Tag tag, const T* HWY_RESTRICT records,
                                   const T* HWY_RESTRICT displacements, const uint16_t* node,
                                   const uint16_t* origin) {
    (void)tag;
    const auto at = [&](size_t place) HWY_ATTR {
      const size_t lane = lane_of(I, place);
      const auto edge = record_difference(records, node[lane], origin[lane]);
      if constexpr (kHasDisplacements) {
        return hn::Add(edge, record_difference(displacements, node[lane], origin[lane]));
      } else {
        return edge;
      }
    };
    if constexpr (kRecordsPerVector == 1) {
      return at(0);
    } else if constexpr (kRecordsPerVector == 2) {
      return hn::Combine(tag, at(1), at(0));
    } else {
      const hn::Half<Tag> half_tag;
      return hn::Combine(tag, hn::Combine(half_tag, at(3), at(2)),
                         hn::Combine(half_tag, at(1), at(0)));
    }
  }

  template <size_t I>
  static HWY_INLINE void scatter(Tag tag, Vec v, T* HWY_RESTRICT records, const uint16_t* node) {
    const RecordTag record_tag;
    (void)tag;
    if constexpr (kRecordsPerVector == 1) {
      add(record_tag, v, records + node[lane_of(I, 0)]);
    } else if constexpr (kRecordsPerVector == 2) {
      add(record_tag, hn::LowerHalf(record_tag, v), records + node[lane_of(I, 0)]);
      add(record_tag, hn::UpperHalf(record_tag, v), records + node[lane_of(I, 1)]);
    } else {
      const hn::Half<Tag> half_tag;
      const auto low = hn::LowerHalf(half_tag, v);
      const auto high = hn::UpperHalf(half_tag, v);
      add(record_tag, hn::LowerHalf(record_tag, low), records + node[lane_of(I, 0)]);
      add(record_tag, hn::UpperHalf(record_tag, low), records + node[lane_of(I, 1)]);
      add(record_tag, hn::LowerHalf(record_tag, high), records + node[lane_of(I, 2)]);
      add(record_tag, hn::UpperHalf(record_tag, high), records + node[lane_of(I, 3)]);
    }
  }

  static HWY_INLINE void transpose(Tag tag, Vec a, Vec b, Vec c, Vec f, Vec* x) {
    if constexpr (sizeof(T) == 8) {
      const Vec ab_low = hn::InterleaveLower(tag, a, b);
      const Vec ab_high = hn::InterleaveUpper(tag, a, b);
      const Vec cf_low = hn::InterleaveLower(tag, c, f);
      const Vec cf_high = hn::InterleaveUpper(tag, c, f);
      x[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(cf_low), ab_low);
      x[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(cf_high), ab_high);
      x[2] = hn::OddEvenBlocks(cf_low, hn::SwapAdjacentBlocks(ab_low));
    } else {
      const hn::RepartitionToWide<Tag> wide;
      const auto ab_low = hn::BitCast(wide, hn::InterleaveLower(tag, a, b));
      const auto ab_high = hn::BitCast(wide, hn::InterleaveUpper(tag, a, b));
      const auto cf_low = hn::BitCast(wide, hn::InterleaveLower(tag, c, f));
      const auto cf_high = hn::BitCast(wide, hn::InterleaveUpper(tag, c, f));
      x[0] = hn::BitCast(tag, hn::InterleaveLower(wide, ab_low, cf_low));
      x[1] = hn::BitCast(tag, hn::InterleaveUpper(wide, ab_low, cf_low));
      x[2] = hn::BitCast(tag, hn::InterleaveLower(wide, ab_high, cf_high));
    }
  }

  static HWY_INLINE void transpose_back(Tag tag, const Vec* x, Vec* packed) {
    const Vec zero = hn::Zero(tag);
    const Vec xy_low = hn::InterleaveLower(tag, x[0], x[1]);
    const Vec xy_high = hn::InterleaveUpper(tag, x[0], x[1]);
    const Vec z_low = hn::InterleaveLower(tag, x[2], zero);
    const Vec z_high = hn::InterleaveUpper(tag, x[2], zero);
    if constexpr (sizeof(T) == 8) {
      packed[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(z_low), xy_low);
      packed[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(z_high), xy_high);
      packed[2] = hn::OddEvenBlocks(z_low, hn::SwapAdjacentBlocks(xy_low));
      packed[3] = hn::OddEvenBlocks(z_high, hn::SwapAdjacentBlocks(xy_high));
    } else {
      const hn::RepartitionToWide<Tag> wide;
      const auto low = hn::BitCast(wide, xy_low);
      const auto high = hn::BitCast(wide, xy_high);
      const auto zl = hn::BitCast(wide, z_low);
      const auto zh = hn::BitCast(wide, z_high);
      packed[0] = hn::BitCast(tag, hn::InterleaveLower(wide, low, zl));
      packed[1] = hn::BitCast(tag, hn::InterleaveUpper(wide, low, zl));
      packed[2] = hn::BitCast(tag, hn::InterleaveLower(wide, high, zh));
      packed[3] = hn::BitCast(tag, hn::InterleaveUpper(wide, high, zh));
    }
  }
};

#endif

/// Data are prefetched this number of batches before they are used.
constexpr size_t kPrefetchDistance = 3;

/// Prefetches `count` numbers into the cache. `data` may lie behind the end of an array, because a
/// prefetch of any address is harmless.
template <class T>
HWY_INLINE void prefetch(const T* data, size_t count) {
  const char* line = reinterpret_cast<const char*>(data);
  for (const char* end = line + count * sizeof(T); line < end; line += 64) hwy::Prefetch(line);
}

// Marks the body of for_each_vector(). The body must be inlined into its loop, because a call for
// every vector would cost a tenth of the time.
#undef TETRACTION_LOOP_BODY
#define TETRACTION_LOOP_BODY HWY_ATTR __attribute__((always_inline))

/// The loop over the elements of a block. It calls body(batch, lane, rest, slots) for every group of
/// kTogether vectors of a batch; `rest` and `slots` point to the data of the group's first lane.
/// Before each batch it calls ahead(batch), which prefetches data of a later batch.
template <class Tag, size_t kTogether = 1, class Ahead, class Body>
HWY_INLINE void for_each_vector(const BatchView& batches, const Ahead& ahead, const Body& body) {
  const double* HWY_RESTRICT rest = batches.rest;
  const uint16_t* HWY_RESTRICT slots = batches.slots;
  for (size_t b = 0; b < static_cast<size_t>(batches.count); ++b) {
    ahead(b);
    prefetch(slots + kPrefetchDistance * 4 * kBatchLanes, 4 * kBatchLanes);
    for (size_t lane = 0; lane < kBatchLanes; lane += kTogether * hn::MaxLanes(Tag())) {
      body(b, lane, rest + lane, slots + lane);
    }
    rest += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
  }
}
/// The same loop with the rest data prefetched, for a body that reads them.
template <class Tag, size_t kTogether = 1, class Body>
HWY_INLINE void for_each_vector(const BatchView& batches, const Body& body) {
  const auto ahead = [&](size_t b) HWY_ATTR {
    prefetch(batches.rest + (b + kPrefetchDistance) * kRestNumbers * kBatchLanes,
             kRestNumbers * kBatchLanes);
  };
  for_each_vector<Tag, kTogether>(batches, ahead, body);
}

/// Returns ln j and sets `inverse` = 1/j. For j near 1, which is the usual case, it uses
/// ln j = 2 artanh s with s = (j − 1)/(j + 1). This keeps the relative accuracy of ln j, and one
/// division gives both results.
template <class Tag, class Vec = hn::Vec<Tag>>
HWY_INLINE Vec log_and_inverse(Tag tag, Vec j, Vec& inverse) {
  const Vec one = hn::Set(tag, 1.0);
  const Vec above = hn::Add(j, one);
  const Vec r = hn::Div(one, hn::Mul(j, above));
  inverse = hn::Mul(r, above);
  const Vec s = hn::Mul(hn::Sub(j, one), hn::Mul(r, j));
  // For |s| ≤ 1/6 the first omitted term of the series is below 1e-18.
  if (HWY_UNLIKELY(!hn::AllTrue(tag, hn::Le(hn::Abs(s), hn::Set(tag, 1.0 / 6.0))))) {
    return hn::Log(tag, j);
  }
  const Vec x = hn::Mul(s, s);
  const Vec x2 = hn::Mul(x, x);
  const auto pair = [&](int k) HWY_ATTR {  // terms k and k + 1
    return hn::MulAdd(hn::Set(tag, 2.0 / (2 * k + 3)), x, hn::Set(tag, 2.0 / (2 * k + 1)));
  };
  const Vec low = hn::MulAdd(pair(2), x2, pair(0));
  const Vec middle = hn::MulAdd(pair(6), x2, pair(4));
  const Vec high = hn::MulAdd(hn::Set(tag, 2.0 / 21), x2, pair(8));
  const Vec x4 = hn::Mul(x2, x2);
  return hn::Mul(s, hn::MulAdd(hn::MulAdd(high, x4, middle), x4, low));
}

/// The sum of the kBatchLanes numbers of a batch. Lanes are added one after the other, so that the
/// result is the same for every vector length.
template <class Tag, class Vec = hn::Vec<Tag>>
HWY_INLINE double sum_of_lanes(Tag tag, const Vec* sums) {
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  HWY_ALIGN double lanes[kBatchLanes];
  for (size_t i = 0; i < kBatchLanes / kLanes; ++i) hn::Store(sums[i], tag, lanes + i * kLanes);
  double total = 0.0;
  for (const double lane : lanes) total += lane;
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
