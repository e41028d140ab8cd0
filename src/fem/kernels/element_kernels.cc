#include "element_kernels.h"

// Portable, SSE4, AVX2 and AVX-512 (Highway's AVX3).
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/element_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "simd_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

// x − ln(1 + x) for |x| ≤ 0.01, see material/strain_invariants.h.
HWY_INLINE V x_minus_log1p(D d, V x) {
  V sum = hn::Set(d, -1.0 / 11);
  for (int k = 10; k >= 2; --k) {
    sum = hn::MulAdd(sum, x, hn::Set(d, ((k % 2 == 0) ? 1.0 : -1.0) / k));
  }
  return hn::Mul(hn::Mul(x, x), sum);
}

// The strain measures a G, with their accuracy near rest: rows of a G = c G − 1.
HWY_INLINE void strain(D d, const Symmetric<V>& c, const Symmetric<V>& vg, V inverse_volume,
                       Columns<V>& ag) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const V sum =
          hn::MulAdd(c(i, 2), vg(2, j), hn::MulAdd(c(i, 1), vg(1, j), hn::Mul(c(i, 0), vg(0, j))));
      ag.m[j][i] =
          i == j ? hn::MulSub(sum, inverse_volume, hn::Set(d, 1.0)) : hn::Mul(sum, inverse_volume);
    }
  }
}

HWY_INLINE V trace(const Columns<V>& m) {
  return hn::Add(m.m[0][0], hn::Add(m.m[1][1], m.m[2][2]));
}

// Below this value of I₁ − 3 − 2 ln J (strains of 3e-3) the plain formula loses digits that matter.
constexpr double kSmallStrain = 1e-5;

// I₁ − 3 − 2 ln J and I₂ − 3 − 4 ln J without cancellation (material/strain_invariants.h), put in
// place of `first` and `second` where the strain is small.
template <bool kSecond>
HWY_INLINE void refine(D d, const Symmetric<V>& c, const Symmetric<V>& vg, V inverse_volume,
                       V& first, V& second) {
  Columns<V> ag;
  strain(d, c, vg, inverse_volume, ag);
  const V tr = trace(ag);
  const V two = hn::Mul(hn::Set(d, 0.5),
                        hn::NegMulAdd(V(hn::Set(d, 1.0)), trace_of_square(d, ag), hn::Mul(tr, tr)));
  Columns<V> cofactor;
  const V three = cofactors(ag, cofactor);
  const V x = hn::Add(tr, hn::Add(two, three));
  const V rest = x_minus_log1p(d, x);
  const auto small =
      hn::And(hn::Lt(first, hn::Set(d, kSmallStrain)), hn::Lt(hn::Abs(x), hn::Set(d, 0.01)));
  first = hn::IfThenElse(small, hn::Sub(rest, hn::Add(two, three)), first);
  if constexpr (kSecond) {
    const V value = hn::Sub(hn::Add(rest, rest), hn::Add(two, hn::Add(three, three)));
    second = hn::IfThenElse(small, value, second);
  }
}

// Above this value of I₁ the formula ½ (I₁² − tr C²) of I₂ loses digits that matter.
constexpr double kLargeStretch = 1e3;

// I₂ = |cof F|² = cof(e)ᵀcof(e) : adj(V G)/V², a sum of squares.
HWY_INLINE V second_invariant(const Columns<V>& cofactor, const Symmetric<V>& vg,
                              V inverse_volume) {
  Symmetric<V> w;
  metric(cofactor, w);
  V sum = hn::Mul(w(0, 0), hn::MulSub(vg(1, 1), vg(2, 2), hn::Mul(vg(1, 2), vg(1, 2))));
  sum = hn::MulAdd(w(1, 1), hn::MulSub(vg(0, 0), vg(2, 2), hn::Mul(vg(0, 2), vg(0, 2))), sum);
  sum = hn::MulAdd(w(2, 2), hn::MulSub(vg(0, 0), vg(1, 1), hn::Mul(vg(0, 1), vg(0, 1))), sum);
  V off = hn::Mul(w(0, 1), hn::MulSub(vg(0, 2), vg(1, 2), hn::Mul(vg(0, 1), vg(2, 2))));
  off = hn::MulAdd(w(0, 2), hn::MulSub(vg(0, 1), vg(1, 2), hn::Mul(vg(0, 2), vg(1, 1))), off);
  off = hn::MulAdd(w(1, 2), hn::MulSub(vg(0, 1), vg(0, 2), hn::Mul(vg(0, 0), vg(1, 2))), off);
  sum = hn::Add(sum, hn::Add(off, off));
  return hn::Mul(sum, hn::Mul(inverse_volume, inverse_volume));
}

struct Moduli {
  V mu, mu2, lambda;
};

// Energy and ∂W/∂e of the elements in the lanes, Mooney–Rivlin and St Venant–Kirchhoff. Returns whether all are admissible.
template <MaterialKind kKind, bool kGradient, bool kEnergy>
HWY_INLINE bool evaluate(D d, const Moduli& moduli, const Columns<V>& e, const Symmetric<V>& vg,
                         V inverse_six_volume, V& energy, Columns<V>& gradient) {
  const V inverse_volume = hn::Mul(inverse_six_volume, hn::Set(d, 6.0));
  if constexpr (kKind == MaterialKind::kStVenantKirchhoff) {
    Symmetric<V> c;
    metric(e, c);
    Columns<V> ag;
    strain(d, c, vg, inverse_volume, ag);
    const V tr = trace(ag);
    const V half_lambda = hn::Mul(hn::Set(d, 0.5), moduli.lambda);
    if constexpr (kEnergy) {
      const V quadratic = hn::Mul(hn::Set(d, 0.25), hn::Mul(moduli.mu, trace_of_square(d, ag)));
      const V volumetric = hn::Mul(hn::Set(d, 0.25), hn::Mul(half_lambda, hn::Mul(tr, tr)));
      energy = hn::Div(hn::Add(quadratic, volumetric), inverse_volume);
    }
    if constexpr (kGradient) {
      // V G a G μ + λ/2 tr V G, symmetric.
      Symmetric<V> stress;
      const V p = hn::Mul(half_lambda, tr);
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
          const V gag = hn::MulAdd(vg(i, 2), ag.m[j][2],
                                   hn::MulAdd(vg(i, 1), ag.m[j][1], hn::Mul(vg(i, 0), ag.m[j][0])));
          stress(i, j) = hn::MulAdd(moduli.mu, gag, hn::Mul(p, vg(i, j)));
        }
      }
      multiply(e, stress, gradient);
    }
    // x − x is NaN for infinite and NaN x.
    return hn::AllTrue(d, hn::Eq(hn::Sub(tr, tr), hn::Zero(d)));
  } else {
    static_assert(kKind == MaterialKind::kMooneyRivlin);
    Columns<V> cofactor;
    const V det = cofactors(e, cofactor);
    const V j = hn::Mul(det, inverse_six_volume);
    V inverse_j;
    const V log_j = log_and_inverse(d, j, inverse_j);
    Columns<V> evg;
    multiply(e, vg, evg);
    const V vi1 = contract(e, evg);  // V I₁
    const V i1 = hn::Mul(vi1, inverse_volume);
    Symmetric<V> c;
    metric(e, c);
    Columns<V> cvg;  // c V G, by columns
    for (int col = 0; col < 3; ++col) {
      for (int i = 0; i < 3; ++i) {
        cvg.m[col][i] = hn::MulAdd(c(i, 2), vg(2, col),
                                   hn::MulAdd(c(i, 1), vg(1, col), hn::Mul(c(i, 0), vg(0, col))));
      }
    }
    Symmetric<V> gcvg;  // V G c G
    for (int i = 0; i < 3; ++i) {
      for (int k = i; k < 3; ++k) {
        const V sum = hn::MulAdd(vg(i, 2), cvg.m[k][2],
                                 hn::MulAdd(vg(i, 1), cvg.m[k][1], hn::Mul(vg(i, 0), cvg.m[k][0])));
        gcvg(i, k) = hn::Mul(sum, inverse_volume);
      }
    }
    if constexpr (kGradient) {
      const V mu_sum = hn::MulAdd(hn::Set(d, 2.0), moduli.mu2, moduli.mu);
      const V factor = hn::Mul(hn::MulSub(moduli.lambda, log_j, mu_sum),
                               hn::Mul(inverse_j, hn::Set(d, 1.0 / 6.0)));
      // V [(μ₁ + μ₂ I₁) G − μ₂ G c G]
      const V scale = hn::MulAdd(moduli.mu2, i1, moduli.mu);
      Symmetric<V> stress;
      for (int k = 0; k < 6; ++k) {
        stress.m[k] = hn::NegMulAdd(moduli.mu2, gcvg.m[k], hn::Mul(scale, vg.m[k]));
      }
      multiply(e, stress, gradient);
      for (int k = 0; k < 9; ++k) {
        gradient.m[k / 3][k % 3] =
            hn::MulAdd(factor, cofactor.m[k / 3][k % 3], gradient.m[k / 3][k % 3]);
      }
    }
    if constexpr (kEnergy) {
      const V volume = hn::Mul(hn::Mul(det, inverse_j), hn::Set(d, 1.0 / 6.0));
      const V three_ln = hn::MulAdd(hn::Set(d, 2.0), log_j, hn::Set(d, 3.0));
      V first = hn::Sub(i1, three_ln);
      // I₂ = ½ (I₁² − tr C²), tr C² = c:(G c G).
      V square = hn::Zero(d);
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) square = hn::MulAdd(c(i, k), gcvg(i, k), square);
      }
      const V half = hn::Set(d, 0.5);
      V i2 = hn::Mul(half, hn::MulSub(i1, i1, hn::Mul(square, inverse_volume)));
      const auto far = hn::Gt(i1, hn::Set(d, kLargeStretch));
      if (HWY_UNLIKELY(!hn::AllFalse(d, far))) {
        i2 = hn::IfThenElse(far, second_invariant(cofactor, vg, inverse_volume), i2);
      }
      V second = hn::Sub(i2, hn::MulAdd(hn::Set(d, 4.0), log_j, hn::Set(d, 3.0)));
      if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Lt(first, hn::Set(d, kSmallStrain))))) {
        refine<true>(d, c, vg, inverse_volume, first, second);
      }
      V density = hn::Mul(hn::Mul(half, moduli.lambda), hn::Mul(log_j, log_j));
      density = hn::MulAdd(hn::Mul(half, moduli.mu), first, density);
      density = hn::MulAdd(hn::Mul(half, moduli.mu2), second, density);
      energy = hn::Mul(volume, density);
    }
    return hn::AllTrue(d, hn::And(hn::Gt(j, hn::Zero(d)), hn::Lt(j, hn::Set(d, 1e300))));
  }
}

template <MaterialKind kKind, bool kGradient, bool kEnergy, bool kChanges>
HWY_NOINLINE BlockSums run(const BatchView& batches, const IsotropicModuli& constants,
                           const double* HWY_RESTRICT positions, const double* HWY_RESTRICT changes,
                           double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  constexpr size_t kParts = kBatchLanes / kLanes;
  const Moduli moduli{hn::Set(d, constants.mu), hn::Set(d, constants.mu2),
                      hn::Set(d, constants.lambda)};
  V sums[kParts];
  for (V& v : sums) v = hn::Zero(d);
  bool admissible = true;
  const double* rest = batches.rest;
  const uint16_t* slots = batches.slots;
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    prefetch(rest + kAhead * kRestNumbers * kBatchLanes, kRestNumbers * kBatchLanes);
    prefetch(slots + kAhead * 4 * kBatchLanes, 4 * kBatchLanes);
    for (size_t part = 0; part < kParts; ++part) {
      const size_t lane = part * kLanes;
      Columns<V> e;
      RowAccess<D>::edges<kChanges>(d, positions, changes, slots + lane, kBatchLanes, e);
      Symmetric<V> vg;
      for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, rest + k * kBatchLanes + lane);
      const V inverse_six_volume = hn::Load(d, rest + 6 * kBatchLanes + lane);
      V energy = hn::Undefined(d);
      Columns<V> gradient;
      admissible &= evaluate<kKind, kGradient, kEnergy>(d, moduli, e, vg, inverse_six_volume,
                                                        energy, gradient);
      if constexpr (kGradient) {
        RowAccess<D>::add_balanced(d, gradient, gradients, slots + lane, kBatchLanes);
      }
      if constexpr (kEnergy) sums[part] = hn::Add(sums[part], energy);
    }
    rest += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
  }
  return {kEnergy ? sum_of_lanes(d, sums) : 0.0, admissible};
}

// Neo-Hookean in stages, so that the long chain of the logarithm of one vector hides behind the other
// vectors of the batch.
struct Stage {
  Columns<V> evg;
  Columns<V> cofactor;
  V det;
  V j;
  V vi1;  // V I₁
};

template <bool kGradient, bool kEnergy, bool kChanges>
HWY_NOINLINE BlockSums run_neo_hookean(const BatchView& batches, const IsotropicModuli& constants,
                                       const double* HWY_RESTRICT positions,
                                       const double* HWY_RESTRICT changes,
                                       double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  constexpr size_t kParts = kBatchLanes / kLanes;
  constexpr size_t kTogether = kParts < 2 ? kParts : 2;
  const V mu = hn::Set(d, constants.mu);
  const V lambda = hn::Set(d, constants.lambda);
  const V half = hn::Set(d, 0.5);
  const V sixth = hn::Set(d, 1.0 / 6.0);
  V sums[kParts];
  for (V& v : sums) v = hn::Zero(d);
  bool admissible = true;
  const double* rest = batches.rest;
  const uint16_t* slots = batches.slots;
  const auto load_vg = [&](size_t lane, Symmetric<V>& vg) HWY_ATTR {
    for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, rest + k * kBatchLanes + lane);
  };
  for (std::ptrdiff_t b = 0; b < batches.count; ++b) {
    prefetch(rest + kAhead * kRestNumbers * kBatchLanes, kRestNumbers * kBatchLanes);
    prefetch(slots + kAhead * 4 * kBatchLanes, 4 * kBatchLanes);
    for (size_t first_part = 0; first_part < kParts; first_part += kTogether) {
      Stage stages[kTogether];
      V log_j[kTogether];
      V inverse_j[kTogether];
      for (size_t i = 0; i < kTogether; ++i) {
        const size_t lane = (first_part + i) * kLanes;
        Stage& s = stages[i];
        Columns<V> e;
        RowAccess<D>::edges<kChanges>(d, positions, changes, slots + lane, kBatchLanes, e);
        s.det = cofactors(e, s.cofactor);
        s.j = hn::Mul(s.det, hn::Load(d, rest + 6 * kBatchLanes + lane));
        Symmetric<V> vg;
        load_vg(lane, vg);
        multiply(e, vg, s.evg);
        if constexpr (kEnergy) s.vi1 = contract(e, s.evg);
      }
      for (size_t i = 0; i < kTogether; ++i) {
        log_j[i] = log_and_inverse(d, stages[i].j, inverse_j[i]);
      }
      for (size_t i = 0; i < kTogether; ++i) {
        const size_t lane = (first_part + i) * kLanes;
        const Stage& s = stages[i];
        admissible &=
            hn::AllTrue(d, hn::And(hn::Gt(s.j, hn::Zero(d)), hn::Lt(s.j, hn::Set(d, 1e300))));
        if constexpr (kEnergy) {
          const V inverse_volume =
              hn::Mul(hn::Load(d, rest + 6 * kBatchLanes + lane), hn::Set(d, 6.0));
          const V three_ln = hn::MulAdd(hn::Set(d, 2.0), log_j[i], hn::Set(d, 3.0));
          V first = hn::MulSub(s.vi1, inverse_volume, three_ln);
          if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Lt(first, hn::Set(d, kSmallStrain))))) {
            Columns<V> e;
            RowAccess<D>::edges<kChanges>(d, positions, changes, slots + lane, kBatchLanes, e);
            Symmetric<V> c;
            metric(e, c);
            Symmetric<V> vg;
            load_vg(lane, vg);
            V second = hn::Undefined(d);
            refine<false>(d, c, vg, inverse_volume, first, second);
          }
          const V volume = hn::Mul(hn::Mul(s.det, inverse_j[i]), sixth);
          const V density = hn::MulAdd(hn::Mul(half, mu), first,
                                       hn::Mul(hn::Mul(half, lambda), hn::Mul(log_j[i], log_j[i])));
          sums[first_part + i] = hn::MulAdd(volume, density, sums[first_part + i]);
        }
        if constexpr (kGradient) {
          const V factor = hn::Mul(hn::MulSub(lambda, log_j[i], mu), hn::Mul(inverse_j[i], sixth));
          Columns<V> gradient;
          for (int k = 0; k < 9; ++k) {
            gradient.m[k / 3][k % 3] =
                hn::MulAdd(factor, s.cofactor.m[k / 3][k % 3], hn::Mul(mu, s.evg.m[k / 3][k % 3]));
          }
          RowAccess<D>::add_balanced(d, gradient, gradients, slots + lane, kBatchLanes);
        }
      }
    }
    rest += kRestNumbers * kBatchLanes;
    slots += 4 * kBatchLanes;
  }
  return {kEnergy ? sum_of_lanes(d, sums) : 0.0, admissible};
}

template <bool kGradient, bool kEnergy, bool kChanges>
BlockSums run_kind(const BatchView& batches, const IsotropicModuli& moduli, const double* positions,
                   const double* changes, double* gradients) {
  switch (moduli.kind) {
    case MaterialKind::kMooneyRivlin:
      return run<MaterialKind::kMooneyRivlin, kGradient, kEnergy, kChanges>(
          batches, moduli, positions, changes, gradients);
    case MaterialKind::kStVenantKirchhoff:
      return run<MaterialKind::kStVenantKirchhoff, kGradient, kEnergy, kChanges>(
          batches, moduli, positions, changes, gradients);
    case MaterialKind::kNeoHookean:
      break;
  }
  return run_neo_hookean<kGradient, kEnergy, kChanges>(batches, moduli, positions, changes,
                                                       gradients);
}

BlockSums gradient_and_energy(const BatchView& batches, const IsotropicModuli& moduli,
                              const double* positions, const double* changes, double* gradients) {
  return changes == nullptr
             ? run_kind<true, true, false>(batches, moduli, positions, nullptr, gradients)
             : run_kind<true, true, true>(batches, moduli, positions, changes, gradients);
}
BlockSums energy_only(const BatchView& batches, const IsotropicModuli& moduli,
                      const double* positions, const double* changes) {
  return changes == nullptr
             ? run_kind<false, true, false>(batches, moduli, positions, nullptr, nullptr)
             : run_kind<false, true, true>(batches, moduli, positions, changes, nullptr);
}
const char* target_name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(gradient_and_energy);
HWY_EXPORT(energy_only);
HWY_EXPORT(target_name);

BlockSums elastic_gradient(const BatchView& batches, const IsotropicModuli& moduli,
                           const double* positions, const double* changes, double* gradients) {
  return HWY_DYNAMIC_DISPATCH(gradient_and_energy)(batches, moduli, positions, changes, gradients);
}

BlockSums elastic_energy(const BatchView& batches, const IsotropicModuli& moduli,
                         const double* positions, const double* changes) {
  return HWY_DYNAMIC_DISPATCH(energy_only)(batches, moduli, positions, changes);
}

const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace tetraction
#endif
