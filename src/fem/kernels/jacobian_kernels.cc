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
  using Tag = hn::CappedTag<double, 8>;
  using Vec = hn::Vec<Tag>;
  const Tag tag;
  size_t negative = 0;
  Vec least = hn::Set(tag, 1.0);
  for_each_vector<Tag>(batches, [&](size_t, size_t, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<Vec> e;
    RecordAccess<Tag>::edges(tag, positions, slots, kBatchLanes, e);
    const auto& m = e.m;
    const Vec x = hn::MulSub(m[1][1], m[2][2], hn::Mul(m[1][2], m[2][1]));
    const Vec y = hn::MulSub(m[1][2], m[2][0], hn::Mul(m[1][0], m[2][2]));
    const Vec z = hn::MulSub(m[1][0], m[2][1], hn::Mul(m[1][1], m[2][0]));
    const Vec det = hn::MulAdd(m[0][0], x, hn::MulAdd(m[0][1], y, hn::Mul(m[0][2], z)));
    const Vec j = hn::Mul(det, hn::Load(tag, rest + 6 * kBatchLanes));
    least = hn::Min(least, j);
    if (!hn::AllFalse(tag, hn::Lt(j, hn::Zero(tag)))) {
      negative += hn::CountTrue(tag, hn::Lt(j, hn::Zero(tag)));
    }
  });
  return {static_cast<std::ptrdiff_t>(negative),
          hn::AllTrue(tag, hn::Gt(least, hn::Set(tag, 0.5)))};
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
