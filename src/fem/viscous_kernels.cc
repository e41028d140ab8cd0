#include "viscous_kernels.h"

// Portable, SSE4, AVX2 and AVX-512 (Highway's AVX3).
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/viscous_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_rows-inl.h"

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

// The edges e in the lanes, and a = eᵀe − c₀.
HWY_INLINE void strain_since(D d, const uint16_t* slots, const double* HWY_RESTRICT positions,
                             const double* HWY_RESTRICT start, Columns<V>& e, Symmetric<V>& a) {
  RowAccess<D>::edges(d, positions, slots, kBatchLanes, e);
  metric(e, a);
  for (size_t k = 0; k < 6; ++k) a.m[k] = hn::Sub(a.m[k], hn::Load(d, start + k * kBatchLanes));
}

// Calls body(batch, lane, rest data) for all lanes of all batches.
template <class Body>
HWY_INLINE void for_all_lanes(const BatchView& batches, const Body& body) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const double* numbers = batches.rest;
  for (size_t b = 0; b < static_cast<size_t>(batches.count); ++b) {
    prefetch(numbers + kAhead * kRestNumbers * kBatchLanes, kRestNumbers * kBatchLanes);
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      body(b, lane, Rest(d, numbers + lane));
    }
    numbers += kRestNumbers * kBatchLanes;
  }
}

HWY_NOINLINE void force(const BatchView& batches, double viscosity,
                        const double* HWY_RESTRICT positions, const double* HWY_RESTRICT velocities,
                        double* HWY_RESTRICT forces) {
  const D d;
  const V factor = hn::Set(d, -viscosity);
  for_all_lanes(batches, [&](size_t b, size_t lane, const Rest& rest) HWY_ATTR {
    const uint16_t* slots = batches.slots + 4 * kBatchLanes * b + lane;
    Columns<V> e;
    Columns<V> rate;
    RowAccess<D>::edges(d, positions, slots, kBatchLanes, e);
    RowAccess<D>::edges(d, velocities, slots, kBatchLanes, rate);
    Symmetric<V> dc;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        V sum = hn::Mul(rate.m[i][0], e.m[j][0]);
        sum = hn::MulAdd(rate.m[j][0], e.m[i][0], sum);
        for (int k = 1; k < 3; ++k) {
          sum = hn::MulAdd(rate.m[i][k], e.m[j][k], sum);
          sum = hn::MulAdd(rate.m[j][k], e.m[i][k], sum);
        }
        dc(i, j) = sum;
      }
    }
    Columns<V> dcvg;
    Symmetric<V> stress;
    pull_back(rest, factor, dc, dcvg, stress);
    Columns<V> result;
    multiply(e, stress, result);
    RowAccess<D>::add_balanced(d, result, forces, slots, kBatchLanes);
  });
}

HWY_NOINLINE void begin_step(const BatchView& batches, const double* HWY_RESTRICT positions,
                             const double* HWY_RESTRICT displacements, double* HWY_RESTRICT start) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const V quarter = hn::Set(d, 0.25);
  for (size_t b = 0; b < static_cast<size_t>(batches.count); ++b) {
    for (size_t lane = 0; lane < kBatchLanes; lane += kLanes) {
      const uint16_t* slots = batches.slots + 4 * kBatchLanes * b + lane;
      Columns<V> edges;
      Symmetric<V> c;
      RowAccess<D>::edges(d, positions, slots, kBatchLanes, edges);
      metric(edges, c);
      if (displacements != nullptr) {
        Symmetric<V> change;
        RowAccess<D>::edges(d, displacements, slots, kBatchLanes, edges);
        metric(edges, change);
        for (size_t k = 0; k < 6; ++k) c.m[k] = hn::NegMulAdd(quarter, change.m[k], c.m[k]);
      }
      double* to = start + kViscousNumbers * kBatchLanes * b + lane;
      for (size_t k = 0; k < 6; ++k) hn::Store(c.m[k], d, to + k * kBatchLanes);
    }
  }
}

template <bool kGradient>
HWY_NOINLINE double gradient(const BatchView& batches, double constant,
                             const double* HWY_RESTRICT start, const double* HWY_RESTRICT positions,
                             double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const V factor = hn::Set(d, constant);
  V sums[kBatchLanes / kLanes];
  for (V& v : sums) v = hn::Zero(d);
  for_all_lanes(batches, [&](size_t b, size_t lane, const Rest& rest) HWY_ATTR {
    const uint16_t* slots = batches.slots + 4 * kBatchLanes * b + lane;
    Columns<V> e;
    Symmetric<V> a;
    strain_since(d, slots, positions, start + kViscousNumbers * kBatchLanes * b + lane, e, a);
    Columns<V> avg;
    if constexpr (kGradient) {
      Symmetric<V> stress;
      pull_back(rest, factor, a, avg, stress);
      Columns<V> result;
      multiply(e, stress, result);
      RowAccess<D>::add_balanced(d, result, gradients, slots, kBatchLanes);
    } else {
      symmetric_times(a, rest.vg, avg);
    }
    sums[lane / kLanes] =
        hn::MulAdd(rest.inverse_volume, trace_of_square(d, avg), sums[lane / kLanes]);
  });
  return 0.25 * constant * sum_of_lanes(d, sums);
}

double gradient_and_energy(const BatchView& batches, double factor, const double* start,
                           const double* positions, double* gradients) {
  return gradient<true>(batches, factor, start, positions, gradients);
}
double energy_only(const BatchView& batches, double factor, const double* start,
                   const double* positions) {
  return gradient<false>(batches, factor, start, positions, nullptr);
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
HWY_INLINE void add_tangent(const BatchView& batches, double constant,
                            const double* HWY_RESTRICT start, const double* HWY_RESTRICT positions,
                            TangentForm form, T* HWY_RESTRICT state) {
  const D d;
  const V factor = hn::Set(d, constant);
  const auto numbers = static_cast<size_t>(tangent_numbers(form)) * kBatchLanes;
  const auto a1 = static_cast<size_t>(tangent_metric_offset(form) + 15) * kBatchLanes;
  for_all_lanes(batches, [&](size_t b, size_t lane, const Rest& rest) HWY_ATTR {
    const uint16_t* slots = batches.slots + 4 * kBatchLanes * b + lane;
    Columns<V> e;
    Symmetric<V> a;
    strain_since(d, slots, positions, start + kViscousNumbers * kBatchLanes * b + lane, e, a);
    Columns<V> avg;
    Symmetric<V> stress;
    pull_back(rest, factor, a, avg, stress);
    T* to = state + numbers * b + lane;
    for (size_t k = 0; k < 6; ++k) add_number(stress.m[k], to + k * kBatchLanes);
    add_number(hn::Div(factor, rest.inverse_volume), to + a1);
  });
}

HWY_NOINLINE void add_tangent_float(const BatchView& batches, double factor, const double* start,
                                    const double* positions, TangentForm form, float* state) {
  add_tangent(batches, factor, start, positions, form, state);
}
HWY_NOINLINE void add_tangent_double(const BatchView& batches, double factor, const double* start,
                                     const double* positions, TangentForm form, double* state) {
  add_tangent(batches, factor, start, positions, form, state);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(force);
HWY_EXPORT(begin_step);
HWY_EXPORT(gradient_and_energy);
HWY_EXPORT(energy_only);
HWY_EXPORT(add_tangent_float);
HWY_EXPORT(add_tangent_double);

void add_viscous_force(const BatchView& batches, double viscosity, const double* positions,
                       const double* velocities, double* forces) {
  HWY_DYNAMIC_DISPATCH(force)(batches, viscosity, positions, velocities, forces);
}

void begin_viscous_step(const BatchView& batches, const double* positions,
                        const double* displacements, double* start) {
  HWY_DYNAMIC_DISPATCH(begin_step)(batches, positions, displacements, start);
}

double viscous_gradient(const BatchView& batches, double factor, const double* start,
                        const double* positions, double* gradients) {
  return gradients == nullptr ? HWY_DYNAMIC_DISPATCH(energy_only)(batches, factor, start, positions)
                              : HWY_DYNAMIC_DISPATCH(gradient_and_energy)(batches, factor, start,
                                                                          positions, gradients);
}

void add_viscous_tangent(const BatchView& batches, double factor, const double* start,
                         const double* positions, TangentForm form, float* state) {
  HWY_DYNAMIC_DISPATCH(add_tangent_float)(batches, factor, start, positions, form, state);
}
void add_viscous_tangent(const BatchView& batches, double factor, const double* start,
                         const double* positions, TangentForm form, double* state) {
  HWY_DYNAMIC_DISPATCH(add_tangent_double)(batches, factor, start, positions, form, state);
}

}  // namespace tetraction
#endif
