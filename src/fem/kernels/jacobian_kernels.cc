#include "jacobian_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/jacobian_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

JacobianSigns signs(const BatchView& batches, const double* positions) {
  using D = hn::CappedTag<double, 8>;
  using V = hn::Vec<D>;
  const D d;
  size_t negative = 0;
  V least = hn::Set(d, 1.0);
  for_each_vector<D>(batches, [&](size_t, size_t, const double* HWY_RESTRICT rest,
                                  const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<V> e;
    RecordAccess<D>::edges(d, positions, slots, kBatchLanes, e);
    const auto& m = e.m;
    const V x = hn::MulSub(m[1][1], m[2][2], hn::Mul(m[1][2], m[2][1]));
    const V y = hn::MulSub(m[1][2], m[2][0], hn::Mul(m[1][0], m[2][2]));
    const V z = hn::MulSub(m[1][0], m[2][1], hn::Mul(m[1][1], m[2][0]));
    const V det = hn::MulAdd(m[0][0], x, hn::MulAdd(m[0][1], y, hn::Mul(m[0][2], z)));
    const V j = hn::Mul(det, hn::Load(d, rest + 6 * kBatchLanes));
    least = hn::Min(least, j);
    if (!hn::AllFalse(d, hn::Lt(j, hn::Zero(d)))) {
      negative += hn::CountTrue(d, hn::Lt(j, hn::Zero(d)));
    }
  });
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
