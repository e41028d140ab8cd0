#include "volume_kernels.h"

#include <cstring>

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

// Stores (x y z 0) of every lane as a record.
HWY_INLINE void store_records(const Vec* x, double* records) {
  const Tag tag;
  hn::StoreInterleaved4(x[0], x[1], x[2], hn::Zero(tag), tag, records);
}
HWY_INLINE void store_records(const Vec* x, float* records) {
  const hn::Rebind<float, Tag> tag;
  hn::StoreInterleaved4(hn::DemoteTo(tag, x[0]), hn::DemoteTo(tag, x[1]), hn::DemoteTo(tag, x[2]),
                        hn::Zero(tag), tag, records);
}

template <bool kHasDisplacements, class T>
HWY_NOINLINE void gradients(const BatchView& batches, const double* HWY_RESTRICT positions,
                            const double* HWY_RESTRICT displacements, T* HWY_RESTRICT records) {
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  constexpr size_t kNumbers = 16;  // of a lane
  const Tag tag;
  HWY_ALIGN T nodes[4][4 * kLanes];
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<Vec> e;
            Columns<Vec> w;
            RecordAccess<Tag>::template edges<kHasDisplacements>(tag, positions, displacements,
                                                                 slots, kBatchLanes, e);
            cofactors(e, w);
            Vec first[3];
            for (int i = 0; i < 3; ++i) {
              first[i] = hn::Neg(hn::Add(w.m[0][i], hn::Add(w.m[1][i], w.m[2][i])));
            }
            store_records(first, nodes[0]);
            for (int k = 0; k < 3; ++k) store_records(w.m[k], nodes[k + 1]);
            for (size_t own = 0; own < kLanes; ++own) {
              T* HWY_RESTRICT to =
                  records + ((lane + own) * static_cast<size_t>(batches.count) + b) * kNumbers;
              for (const auto& of_node : nodes) {
                std::memcpy(to, of_node + 4 * own, 4 * sizeof(T));
                to += 4;
              }
            }
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

template <class T>
void gradients_in(const BatchView& batches, const double* positions, const double* displacements,
                  T* records) {
  if (displacements == nullptr) {
    gradients<false>(batches, positions, nullptr, records);
  } else {
    gradients<true>(batches, positions, displacements, records);
  }
}
// Highway's dispatch needs functions that are not overloaded.
void gradients_float(const BatchView& batches, const double* positions, const double* displacements,
                     float* records) {
  gradients_in(batches, positions, displacements, records);
}
void gradients_double(const BatchView& batches, const double* positions,
                      const double* displacements, double* records) {
  gradients_in(batches, positions, displacements, records);
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
HWY_EXPORT(gradients_float);
HWY_EXPORT(gradients_double);
HWY_EXPORT(gradient_of);

void element_volumes(const BatchView& batches, const double* positions, const double* displacements,
                     double* six_volumes) {
  HWY_DYNAMIC_DISPATCH(volumes_of)(batches, positions, displacements, six_volumes);
}

void element_volume_gradients(const BatchView& batches, const double* positions,
                              const double* displacements, float* gradients) {
  HWY_DYNAMIC_DISPATCH(gradients_float)(batches, positions, displacements, gradients);
}
void element_volume_gradients(const BatchView& batches, const double* positions,
                              const double* displacements, double* gradients) {
  HWY_DYNAMIC_DISPATCH(gradients_double)(batches, positions, displacements, gradients);
}

void add_volume_gradient(const BatchView& batches, const double* positions,
                         const double* displacements, double* forces) {
  HWY_DYNAMIC_DISPATCH(gradient_of)(batches, positions, displacements, forces);
}

}  // namespace tetraction
#endif
