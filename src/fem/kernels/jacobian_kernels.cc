#include "jacobian_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/jacobian_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "element_values.h"
#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Tag = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Tag>;

JacobianSigns signs(const BatchView& batches, const double* positions) {
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

bool keeps_volumes(const BatchView& batches, const double* HWY_RESTRICT positions,
                   const double* HWY_RESTRICT displacements) {
  const Tag tag;
  const Vec zero = hn::Zero(tag);
  const auto dot = [&](const Columns<Vec>& a, const Columns<Vec>& b) HWY_ATTR {
    Vec sum = hn::Mul(a.m[0][0], b.m[0][0]);
    for (int k = 1; k < 9; ++k) sum = hn::MulAdd(a.m[k / 3][k % 3], b.m[k / 3][k % 3], sum);
    return sum;
  };
  Vec least = hn::Set(tag, 1.0);
  for_each_vector<Tag>(batches, [&](size_t, size_t, const double*,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<Vec> e;
    Columns<Vec> d;
    RecordAccess<Tag>::edges(tag, positions, slots, kBatchLanes, e);
    RecordAccess<Tag>::edges(tag, displacements, slots, kBatchLanes, d);
    Columns<Vec> w;
    const Vec det = cofactors(e, w);
    const Vec first = dot(w, d);
    const Vec third = cofactors(d, w);
    const Vec second = dot(w, e);
    const Vec loss =
        hn::Add(hn::Min(first, zero), hn::Add(hn::Min(second, zero), hn::Min(third, zero)));
    // An element without a volume at q fails, too, because its margin is not positive.
    const Vec margin = hn::MulAdd(det, hn::Set(tag, 0.9), loss);
    least = hn::Min(least, hn::IfThenElse(hn::Gt(margin, zero), least, zero));
  });
  return hn::AllTrue(tag, hn::Gt(least, zero));
}

LargestChanges changes(const BatchView& batches, const double* HWY_RESTRICT displacements) {
  const Tag tag;
  Vec square = hn::Zero(tag);
  Vec by_lengths = hn::Zero(tag);
  for_each_vector<Tag>(batches, [&](size_t, size_t, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<Vec> d;
    RecordAccess<Tag>::edges(tag, displacements, slots, kBatchLanes, d);
    Vec sum = hn::Zero(tag);
    for (int k = 0; k < 9; ++k) sum = hn::MulAdd(d.m[k / 3][k % 3], d.m[k / 3][k % 3], sum);
    // The trace of V G, and 1/V.
    const Vec trace = hn::Add(hn::Load(tag, rest), hn::Add(hn::Load(tag, rest + 3 * kBatchLanes),
                                                           hn::Load(tag, rest + 5 * kBatchLanes)));
    const Vec inverse_volume = hn::Mul(hn::Set(tag, 6.0), hn::Load(tag, rest + 6 * kBatchLanes));
    const Vec slenderness = hn::Mul(trace, inverse_volume);
    const Vec change = hn::Mul(sum, slenderness);
    square = hn::Max(square, change);
    by_lengths = hn::Max(by_lengths, hn::Mul(change, slenderness));
  });
  return {hn::GetLane(hn::MaxOfLanes(tag, square)), hn::GetLane(hn::MaxOfLanes(tag, by_lengths))};
}

// F = e D_m⁻¹ = e wᵀ/det D_m with the cofactors w of the rest edges D_m.
void deformations(const BatchView& batches, const double* HWY_RESTRICT rest_positions,
                  const double* HWY_RESTRICT positions, double* HWY_RESTRICT values) {
  const Tag tag;
  for_each_vector<Tag>(batches, [&](size_t batch, size_t lane, const double*,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<Vec> rest;
    Columns<Vec> e;
    RecordAccess<Tag>::edges(tag, rest_positions, slots, kBatchLanes, rest);
    RecordAccess<Tag>::edges(tag, positions, slots, kBatchLanes, e);
    Columns<Vec> w;
    const Vec inverse = hn::Div(hn::Set(tag, 1.0), cofactors(rest, w));
    Columns<Vec> f;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        const Vec sum = hn::MulAdd(e.m[2][i], w.m[2][j],
                                   hn::MulAdd(e.m[1][i], w.m[1][j], hn::Mul(e.m[0][i], w.m[0][j])));
        f.m[j][i] = hn::Mul(sum, inverse);
      }
    }
    double* HWY_RESTRICT to = values + batch * kValueNumbers * kBatchLanes + lane;
    hn::Store(cofactors(f, w), tag, to);
    Symmetric<Vec> c;
    metric(f, c);
    constexpr int kEntries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
    for (const auto& [i, j] : kEntries) {
      to += kBatchLanes;
      const Vec change = i == j ? hn::Sub(c(i, j), hn::Set(tag, 1.0)) : c(i, j);
      hn::Store(hn::Mul(change, hn::Set(tag, 0.5)), tag, to);
    }
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(signs);
HWY_EXPORT(deformations);
HWY_EXPORT(keeps_volumes);
HWY_EXPORT(changes);

JacobianSigns jacobian_signs(const BatchView& batches, const double* positions) {
  return HWY_DYNAMIC_DISPATCH(signs)(batches, positions);
}

bool way_keeps_volumes(const BatchView& batches, const double* positions,
                       const double* displacements) {
  return HWY_DYNAMIC_DISPATCH(keeps_volumes)(batches, positions, displacements);
}

LargestChanges largest_changes(const BatchView& batches, const double* displacements) {
  return HWY_DYNAMIC_DISPATCH(changes)(batches, displacements);
}

void element_deformations(const BatchView& batches, const double* rest_positions,
                          const double* positions, double* values) {
  HWY_DYNAMIC_DISPATCH(deformations)(batches, rest_positions, positions, values);
}

}  // namespace tetraction
#endif
