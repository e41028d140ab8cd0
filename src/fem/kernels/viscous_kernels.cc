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

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

/// Rest data of the elements in the lanes.
struct Rest {
  Symmetric<V> vg;
  V inverse_volume;

  HWY_INLINE Rest(D d, const double* HWY_RESTRICT at) {
    for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, at + k * kBatchLanes);
    inverse_volume = hn::Mul(hn::Load(d, at + 6 * kBatchLanes), hn::Set(d, 6.0));
  }
};

// factor V G a G, symmetric as a is; avg = a V G.
HWY_INLINE void pull_back(const Rest& rest, V factor, const Symmetric<V>& a, Columns<V>& avg,
                          Symmetric<V>& result) {
  symmetric_times(a, rest.vg, avg);
  symmetric_product(rest.vg, avg, result);
  const V scale = hn::Mul(factor, rest.inverse_volume);
  for (V& number : result.m) number = hn::Mul(scale, number);
}

// aᵀb + bᵀa.
HWY_INLINE void symmetric_sum(const Columns<V>& a, const Columns<V>& b, Symmetric<V>& result) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      V sum = hn::Mul(a.m[i][0], b.m[j][0]);
      sum = hn::MulAdd(a.m[j][0], b.m[i][0], sum);
      for (int k = 1; k < 3; ++k) {
        sum = hn::MulAdd(a.m[i][k], b.m[j][k], sum);
        sum = hn::MulAdd(a.m[j][k], b.m[i][k], sum);
      }
      result(i, j) = sum;
    }
  }
}

// The edges e = e₀ + δ of the elements in the lanes, and a = (e₀ + ½δ)ᵀδ + δᵀ(e₀ + ½δ) + c.
HWY_INLINE void strain_of_step(D d, const uint16_t* slots, const ViscousStep& step, size_t numbers,
                               Columns<V>& e, Symmetric<V>& a) {
  Columns<V> change;
  Columns<V> middle;
  RecordAccess<D>::edges(d, step.positions, slots, kBatchLanes, e);
  RecordAccess<D>::edges(d, step.displacements, slots, kBatchLanes, change);
  const V half = hn::Set(d, 0.5);
  for (int k = 0; k < 9; ++k) {
    const V delta = change.m[k / 3][k % 3];
    V& edge = e.m[k / 3][k % 3];
    middle.m[k / 3][k % 3] = hn::MulAdd(half, delta, edge);
    edge = hn::Add(edge, delta);
  }
  symmetric_sum(middle, change, a);
  if (step.correction == nullptr) return;
  for (size_t k = 0; k < 6; ++k) {
    a.m[k] = hn::Add(a.m[k], hn::Load(d, step.correction + numbers + k * kBatchLanes));
  }
}

// Calls body(batch, lane, rest data, slots) for all lanes of all batches.
template <class Body>
HWY_INLINE void for_all_lanes(const BatchView& batches, const Body& body) {
  for_each_vector<D>(batches, [&](size_t b, size_t lane, const double* HWY_RESTRICT rest,
                                  const uint16_t* HWY_RESTRICT slots)
                                  TETRACTION_LOOP_BODY { body(b, lane, Rest(D(), rest), slots); });
}

HWY_NOINLINE void force(const BatchView& batches, double viscosity,
                        const double* HWY_RESTRICT positions, const double* HWY_RESTRICT velocities,
                        double* HWY_RESTRICT forces) {
  const D d;
  const V factor = hn::Set(d, -viscosity);
  for_all_lanes(batches, [&](size_t, size_t, const Rest& rest, const uint16_t* slots) HWY_ATTR {
    Columns<V> e;
    Columns<V> rate;
    RecordAccess<D>::edges(d, positions, slots, kBatchLanes, e);
    RecordAccess<D>::edges(d, velocities, slots, kBatchLanes, rate);
    Symmetric<V> dc;
    symmetric_sum(rate, e, dc);
    Columns<V> dcvg;
    Symmetric<V> stress;
    pull_back(rest, factor, dc, dcvg, stress);
    Columns<V> result;
    multiply(e, stress, result);
    RecordAccess<D>::add_balanced(d, result, forces, slots, kBatchLanes);
  });
}

HWY_NOINLINE void correction(const BatchView& batches, const double* HWY_RESTRICT displacements,
                             double* HWY_RESTRICT result) {
  const D d;
  for_each_vector<D>(
      batches, [](size_t) {},
      [&](size_t b, size_t lane, const double*, const uint16_t* HWY_RESTRICT slots)
          TETRACTION_LOOP_BODY {
            Columns<V> edges;
            Symmetric<V> c;
            RecordAccess<D>::edges(d, displacements, slots, kBatchLanes, edges);
            metric(edges, c);
            double* to = result + kViscousNumbers * kBatchLanes * b + lane;
            for (size_t k = 0; k < 6; ++k) hn::Store(c.m[k], d, to + k * kBatchLanes);
          });
}

template <bool kGradient>
HWY_NOINLINE double gradient(const BatchView& batches, const ViscousStep& step,
                             double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const V factor = hn::Set(d, step.factor);
  V sums[kBatchLanes / kLanes];
  for (V& v : sums) v = hn::Zero(d);
  for_all_lanes(batches,
                [&](size_t b, size_t lane, const Rest& rest, const uint16_t* slots) HWY_ATTR {
                  Columns<V> e;
                  Symmetric<V> a;
                  strain_of_step(d, slots, step, kViscousNumbers * kBatchLanes * b + lane, e, a);
                  Columns<V> avg;
                  if constexpr (kGradient) {
                    Symmetric<V> stress;
                    pull_back(rest, factor, a, avg, stress);
                    Columns<V> result;
                    multiply(e, stress, result);
                    RecordAccess<D>::add_balanced(d, result, gradients, slots, kBatchLanes);
                  } else {
                    symmetric_times(a, rest.vg, avg);
                  }
                  sums[lane / kLanes] =
                      hn::MulAdd(rest.inverse_volume, trace_of_square(d, avg), sums[lane / kLanes]);
                });
  return 0.25 * step.factor * sum_of_lanes(d, sums);
}

double gradient_and_energy(const BatchView& batches, const ViscousStep& step, double* gradients) {
  return gradient<true>(batches, step, gradients);
}
double energy_only(const BatchView& batches, const ViscousStep& step) {
  return gradient<false>(batches, step, nullptr);
}

HWY_INLINE void add_number(V v, double* to) {
  const D d;
  hn::Store(hn::Add(hn::Load(d, to), v), d, to);
}
HWY_INLINE void add_number(V v, float* to) {
  const D d;
  const hn::Rebind<float, D> narrow;
  hn::Store(hn::DemoteTo(narrow, hn::Add(hn::PromoteTo(d, hn::Load(narrow, to)), v)), narrow, to);
}

template <class T>
HWY_INLINE void add_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                            T* HWY_RESTRICT state) {
  const D d;
  const V factor = hn::Set(d, step.factor);
  const auto numbers = static_cast<size_t>(tangent_numbers(form)) * kBatchLanes;
  const auto a1 = static_cast<size_t>(tangent_metric_offset(form) + 15) * kBatchLanes;
  for_all_lanes(batches,
                [&](size_t b, size_t lane, const Rest& rest, const uint16_t* slots) HWY_ATTR {
                  Columns<V> e;
                  Symmetric<V> a;
                  strain_of_step(d, slots, step, kViscousNumbers * kBatchLanes * b + lane, e, a);
                  Columns<V> avg;
                  Symmetric<V> stress;
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
