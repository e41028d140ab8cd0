#include "viscous_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/viscous_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Tag = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Tag>;

/// Rest data of the elements in the lanes.
struct Rest {
  Symmetric<Vec> vg;
  Vec inverse_volume;

  HWY_INLINE Rest(Tag tag, const double* HWY_RESTRICT at) {
    for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(tag, at + k * kBatchLanes);
    inverse_volume = hn::Mul(hn::Load(tag, at + 6 * kBatchLanes), hn::Set(tag, 6.0));
  }
};

// Computes avg = a V G and result = factor V G a G for a symmetric a.
HWY_INLINE void pull_back(const Rest& rest, Vec factor, const Symmetric<Vec>& a, Columns<Vec>& avg,
                          Symmetric<Vec>& result) {
  symmetric_times(a, rest.vg, avg);
  symmetric_product(rest.vg, avg, result);
  const Vec scale = hn::Mul(factor, rest.inverse_volume);
  for (Vec& number : result.m) number = hn::Mul(scale, number);
}

// Computes the edges e = e₀ + δ of the elements in the lanes and a = (e₀ + ½δ)ᵀδ + δᵀ(e₀ + ½δ) + c.
HWY_INLINE void strain_of_step(Tag tag, const uint16_t* slots, const ViscousStep& step,
                               size_t numbers, Columns<Vec>& e, Symmetric<Vec>& a) {
  Columns<Vec> delta_edges;
  Columns<Vec> midpoint_edges;
  RecordAccess<Tag>::edges(tag, step.positions, slots, kBatchLanes, e);
  RecordAccess<Tag>::edges(tag, step.displacements, slots, kBatchLanes, delta_edges);
  const Vec half = hn::Set(tag, 0.5);
  for (int k = 0; k < 9; ++k) {
    const Vec delta = delta_edges.m[k / 3][k % 3];
    Vec& edge = e.m[k / 3][k % 3];
    midpoint_edges.m[k / 3][k % 3] = hn::MulAdd(half, delta, edge);
    edge = hn::Add(edge, delta);
  }
  symmetric_sum(midpoint_edges, delta_edges, a);
  if (step.correction == nullptr) return;
  for (size_t k = 0; k < 6; ++k) {
    a.m[k] = hn::Add(a.m[k], hn::Load(tag, step.correction + numbers + k * kBatchLanes));
  }
}

// Calls body(batch, lane, rest, slots) for all vectors of all batches.
template <class Body>
HWY_INLINE void for_all_lanes(const BatchView& batches, const Body& body) {
  for_each_vector<Tag>(batches, [&](size_t b, size_t lane, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    body(b, lane, Rest(Tag(), rest), slots);
  });
}

HWY_NOINLINE void force(const BatchView& batches, double viscosity,
                        const double* HWY_RESTRICT positions, const double* HWY_RESTRICT velocities,
                        double* HWY_RESTRICT forces) {
  const Tag tag;
  const Vec factor = hn::Set(tag, -viscosity);
  for_all_lanes(batches, [&](size_t, size_t, const Rest& rest, const uint16_t* slots) HWY_ATTR {
    Columns<Vec> e;
    Columns<Vec> rate;
    RecordAccess<Tag>::edges(tag, positions, slots, kBatchLanes, e);
    RecordAccess<Tag>::edges(tag, velocities, slots, kBatchLanes, rate);
    Symmetric<Vec> dc;
    symmetric_sum(rate, e, dc);
    Columns<Vec> dcvg;
    Symmetric<Vec> stress;
    pull_back(rest, factor, dc, dcvg, stress);
    Columns<Vec> result;
    multiply(e, stress, result);
    RecordAccess<Tag>::add_balanced(tag, result, forces, slots, kBatchLanes);
  });
}

HWY_NOINLINE void correction(const BatchView& batches, const double* HWY_RESTRICT displacements,
                             double* HWY_RESTRICT result) {
  const Tag tag;
  for_each_vector<Tag>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<Vec> edges;
            Symmetric<Vec> c;
            RecordAccess<Tag>::edges(tag, displacements, slots, kBatchLanes, edges);
            metric(edges, c);
            double* to = result + kViscousNumbers * kBatchLanes * b + lane;
            for (size_t k = 0; k < 6; ++k) hn::Store(c.m[k], tag, to + k * kBatchLanes);
          });
}

template <bool kGradient>
HWY_NOINLINE double gradient(const BatchView& batches, const ViscousStep& step,
                             double* HWY_RESTRICT gradients) {
  const Tag tag;
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  const Vec factor = hn::Set(tag, step.factor);
  Vec sums[kBatchLanes / kLanes];
  for (Vec& v : sums) v = hn::Zero(tag);
  for_all_lanes(
      batches, [&](size_t b, size_t lane, const Rest& rest, const uint16_t* slots) HWY_ATTR {
        Columns<Vec> e;
        Symmetric<Vec> a;
        strain_of_step(tag, slots, step, kViscousNumbers * kBatchLanes * b + lane, e, a);
        Columns<Vec> avg;
        if constexpr (kGradient) {
          Symmetric<Vec> stress;
          pull_back(rest, factor, a, avg, stress);
          Columns<Vec> result;
          multiply(e, stress, result);
          RecordAccess<Tag>::add_balanced(tag, result, gradients, slots, kBatchLanes);
        } else {
          symmetric_times(a, rest.vg, avg);
        }
        sums[lane / kLanes] =
            hn::MulAdd(rest.inverse_volume, trace_of_square(tag, avg), sums[lane / kLanes]);
      });
  return 0.25 * step.factor * sum_of_lanes(tag, sums);
}

double gradient_and_energy(const BatchView& batches, const ViscousStep& step, double* gradients) {
  return gradient<true>(batches, step, gradients);
}
double energy_only(const BatchView& batches, const ViscousStep& step) {
  return gradient<false>(batches, step, nullptr);
}

HWY_INLINE void add_number(Vec v, double* to) {
  const Tag tag;
  hn::Store(hn::Add(hn::Load(tag, to), v), tag, to);
}
HWY_INLINE void add_number(Vec v, float* to) {
  const Tag tag;
  const hn::Rebind<float, Tag> narrow;
  hn::Store(hn::DemoteTo(narrow, hn::Add(hn::PromoteTo(tag, hn::Load(narrow, to)), v)), narrow, to);
}

template <class T>
HWY_INLINE void add_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                            T* HWY_RESTRICT state) {
  const Tag tag;
  const Vec factor = hn::Set(tag, step.factor);
  const auto numbers = static_cast<size_t>(tangent_numbers(form)) * kBatchLanes;
  const auto a1 = static_cast<size_t>(tangent_metric_offset(form) + 15) * kBatchLanes;
  for_all_lanes(batches,
                [&](size_t b, size_t lane, const Rest& rest, const uint16_t* slots) HWY_ATTR {
                  Columns<Vec> e;
                  Symmetric<Vec> a;
                  strain_of_step(tag, slots, step, kViscousNumbers * kBatchLanes * b + lane, e, a);
                  Columns<Vec> avg;
                  Symmetric<Vec> stress;
                  pull_back(rest, factor, a, avg, stress);
                  T* to = state + numbers * b + lane;
                  for (size_t k = 0; k < 6; ++k) add_number(stress.m[k], to + k * kBatchLanes);
                  add_number(hn::Div(factor, rest.inverse_volume), to + a1);
                });
}

HWY_NOINLINE void add_tangent_float(const BatchView& batches, const ViscousStep& step,
                                    TangentForm form, float* state) {
  add_tangent(batches, step, form, state);
}
HWY_NOINLINE void add_tangent_double(const BatchView& batches, const ViscousStep& step,
                                     TangentForm form, double* state) {
  add_tangent(batches, step, form, state);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(force);
HWY_EXPORT(correction);
HWY_EXPORT(gradient_and_energy);
HWY_EXPORT(energy_only);
HWY_EXPORT(add_tangent_float);
HWY_EXPORT(add_tangent_double);

void add_viscous_force(const BatchView& batches, double viscosity, const double* positions,
                       const double* velocities, double* forces) {
  HWY_DYNAMIC_DISPATCH(force)(batches, viscosity, positions, velocities, forces);
}

void viscous_correction(const BatchView& batches, const double* displacements, double* result) {
  HWY_DYNAMIC_DISPATCH(correction)(batches, displacements, result);
}

double viscous_gradient(const BatchView& batches, const ViscousStep& step, double* gradients) {
  return gradients == nullptr ? HWY_DYNAMIC_DISPATCH(energy_only)(batches, step)
                              : HWY_DYNAMIC_DISPATCH(gradient_and_energy)(batches, step, gradients);
}

void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         float* state) {
  HWY_DYNAMIC_DISPATCH(add_tangent_float)(batches, step, form, state);
}
void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         double* state) {
  HWY_DYNAMIC_DISPATCH(add_tangent_double)(batches, step, form, state);
}

}  // namespace tetraction
#endif
