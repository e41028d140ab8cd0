#include "volume_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/volume_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Tag = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Tag>;

template <bool kHasDisplacements>
HWY_NOINLINE void volumes(const BatchView& batches, const double* HWY_RESTRICT positions,
                          const double* HWY_RESTRICT displacements,
                          double* HWY_RESTRICT six_volumes) {
  const Tag tag;
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<Vec> e;
            RecordAccess<Tag>::template edges<kHasDisplacements>(tag, positions, displacements,
                                                                 slots, kBatchLanes, e);
            const auto& m = e.m;
            const Vec x = hn::MulSub(m[1][1], m[2][2], hn::Mul(m[1][2], m[2][1]));
            const Vec y = hn::MulSub(m[1][2], m[2][0], hn::Mul(m[1][0], m[2][2]));
            const Vec z = hn::MulSub(m[1][0], m[2][1], hn::Mul(m[1][1], m[2][0]));
            const Vec det = hn::MulAdd(m[0][0], x, hn::MulAdd(m[0][1], y, hn::Mul(m[0][2], z)));
            hn::Store(det, tag, six_volumes + b * kBatchLanes + lane);
          });
}

template <bool kHasDisplacements>
HWY_NOINLINE void gradient(const BatchView& batches, const double* HWY_RESTRICT positions,
                           const double* HWY_RESTRICT displacements, double* HWY_RESTRICT forces) {
  const Tag tag;
  const Vec sixth = hn::Set(tag, 1.0 / 6.0);
  const double* HWY_RESTRICT tensions = batches.tensions;
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<Vec> e;
            Columns<Vec> w;
            RecordAccess<Tag>::template edges<kHasDisplacements>(tag, positions, displacements,
                                                                 slots, kBatchLanes, e);
            cofactors(e, w);
            const Vec factor = hn::Mul(hn::Load(tag, tensions + b * kBatchLanes + lane), sixth);
            for (int k = 0; k < 9; ++k) w.m[k / 3][k % 3] = hn::Mul(factor, w.m[k / 3][k % 3]);
            RecordAccess<Tag>::add_balanced(tag, w, forces, slots, kBatchLanes);
          });
}

void volumes_of(const BatchView& batches, const double* positions, const double* displacements,
                double* six_volumes) {
  if (displacements == nullptr) {
    volumes<false>(batches, positions, nullptr, six_volumes);
  } else {
    volumes<true>(batches, positions, displacements, six_volumes);
  }
}

void gradient_of(const BatchView& batches, const double* positions, const double* displacements,
                 double* forces) {
  if (displacements == nullptr) {
    gradient<false>(batches, positions, nullptr, forces);
  } else {
    gradient<true>(batches, positions, displacements, forces);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(volumes_of);
HWY_EXPORT(gradient_of);

void element_volumes(const BatchView& batches, const double* positions, const double* displacements,
                     double* six_volumes) {
  HWY_DYNAMIC_DISPATCH(volumes_of)(batches, positions, displacements, six_volumes);
}

void add_volume_gradient(const BatchView& batches, const double* positions,
                         const double* displacements, double* forces) {
  HWY_DYNAMIC_DISPATCH(gradient_of)(batches, positions, displacements, forces);
}

}  // namespace tetraction
#endif
