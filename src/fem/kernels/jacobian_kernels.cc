#include "jacobian_kernels.h"

// Portable, SSE4, AVX2 and AVX-512 (Highway's AVX3).
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/jacobian_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

JacobianSigns signs(const BatchView& batches, const double* positions) {
  using D = hn::CappedTag<double, 8>;
  using V = hn::Vec<D>;
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const double* inverse_six_volumes = batches.rest + 6 * kBatchLanes;
  const uint16_t* slots = batches.slots;
  size_t negative = 0;
  V least = hn::Set(d, 1.0);
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      Columns<V> e;
      RowAccess<D>::edges(d, positions, slots + lane, kBatchLanes, e);
      const auto& m = e.m;
      const V x = hn::MulSub(m[1][1], m[2][2], hn::Mul(m[1][2], m[2][1]));
      const V y = hn::MulSub(m[1][2], m[2][0], hn::Mul(m[1][0], m[2][2]));
      const V z = hn::MulSub(m[1][0], m[2][1], hn::Mul(m[1][1], m[2][0]));
      const V det = hn::MulAdd(m[0][0], x, hn::MulAdd(m[0][1], y, hn::Mul(m[0][2], z)));
      const V j = hn::Mul(det, hn::Load(d, inverse_six_volumes + lane));
      least = hn::Min(least, j);
      if (!hn::AllFalse(d, hn::Lt(j, hn::Zero(d)))) {
        negative += hn::CountTrue(d, hn::Lt(j, hn::Zero(d)));
      }
    }
    inverse_six_volumes += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
  }
  return {static_cast<std::ptrdiff_t>(negative), hn::AllTrue(d, hn::Gt(least, hn::Set(d, 0.5)))};
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(signs);

JacobianSigns jacobian_signs(const BatchView& batches, const double* positions) {
  return HWY_DYNAMIC_DISPATCH(signs)(batches, positions);
}

}  // namespace tetraction
#endif
