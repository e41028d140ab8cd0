#include "element_kernels.h"

#include <variant>

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/element_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "material/laws/laws-inl.h"
#include "simd_records-inl.h"

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

using N = Number<D>;

// Rest data of the elements in the lanes.
HWY_INLINE void load_rest(D d, const double* HWY_RESTRICT rest, Symmetric<V>& vg) {
  for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(d, rest + k * kBatchLanes);
}
HWY_INLINE V load_inverse_six_volume(D d, const double* HWY_RESTRICT rest) {
  return hn::Load(d, rest + 6 * kBatchLanes);
}

// J > 0 and finite in all lanes.
HWY_INLINE bool all_positive(D d, V j) {
  return hn::AllTrue(d, hn::And(hn::Gt(j, hn::Zero(d)), hn::Lt(j, hn::Set(d, 1e300))));
}

// Energy and ∂W/∂e of the elements in the lanes, of a law defined for any J. Returns whether all
// are admissible.
template <bool kGradient, class M>
HWY_INLINE bool evaluate_strain(D d, const M& material, const Columns<V>& e, const Symmetric<V>& vg,
                                V inverse_six_volume, V& energy, Columns<V>& gradient) {
  const V inverse_volume = hn::Mul(inverse_six_volume, hn::Set(d, 6.0));
  Symmetric<V> c;
  metric(e, c);
  Columns<V> ag;
  strain(d, c, vg, inverse_volume, ag);
  const V tr = trace(ag);
  const StrainMeasures<N> s{N(tr), N(trace_of_square(d, ag))};
  energy = hn::Div(Law<M>::energy(material, s).v, inverse_volume);
  if constexpr (kGradient) {
    const V minus = (N(-2.0) * Law<M>::first(material, s).i2).v;
    const V p = (N(2.0) * Law<M>::spherical(material, s)).v;
    Symmetric<V> stress;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        const V gag = hn::MulAdd(vg(i, 2), ag.m[j][2],
                                 hn::MulAdd(vg(i, 1), ag.m[j][1], hn::Mul(vg(i, 0), ag.m[j][0])));
        stress(i, j) = hn::MulAdd(minus, gag, hn::Mul(p, vg(i, j)));
      }
    }
    multiply(e, stress, gradient);
  }
  // x − x is NaN for infinite and NaN x.
  return hn::AllTrue(d, hn::Eq(hn::Sub(tr, tr), hn::Zero(d)));
}

// The same for a law with I₂ that needs J > 0.
template <bool kGradient, class M>
HWY_INLINE bool evaluate_i2(D d, const M& material, const Columns<V>& e, const Symmetric<V>& vg,
                            V inverse_six_volume, V& energy, Columns<V>& gradient) {
  const V inverse_volume = hn::Mul(inverse_six_volume, hn::Set(d, 6.0));
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
  symmetric_times(c, vg, cvg);
  Symmetric<V> gcvg;  // V G c G
  symmetric_product(vg, cvg, gcvg);
  for (V& number : gcvg.m) number = hn::Mul(number, inverse_volume);

  V first = hn::Sub(i1, hn::MulAdd(hn::Set(d, 2.0), log_j, hn::Set(d, 3.0)));
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
  const Invariants<N> s{N(i1), N(first), N(second), N(log_j), N(j), N(j) - N(1.0)};
  if constexpr (kGradient) {
    const auto derivatives = Law<M>::first(material, s);
    const V factor =
        hn::Mul(derivatives.log_j.v, hn::Mul(inverse_j, hn::Set(d, 1.0 / 6.0)));  // Ψ_L V/det e
    // V [2 (Ψ₁ + Ψ₂ I₁) G − 2 Ψ₂ G c G]
    const V twice_i2 = (N(2.0) * derivatives.i2).v;
    const V scale = hn::MulAdd(twice_i2, i1, (N(2.0) * derivatives.i1).v);
    Symmetric<V> stress;
    for (int k = 0; k < 6; ++k) {
      stress.m[k] = hn::NegMulAdd(twice_i2, gcvg.m[k], hn::Mul(scale, vg.m[k]));
    }
    multiply(e, stress, gradient);
    for (int k = 0; k < 9; ++k) {
      gradient.m[k / 3][k % 3] =
          hn::MulAdd(factor, cofactor.m[k / 3][k % 3], gradient.m[k / 3][k % 3]);
    }
  }
  const V volume = hn::Mul(hn::Mul(det, inverse_j), hn::Set(d, 1.0 / 6.0));
  energy = hn::Mul(volume, Law<M>::energy(material, s).v);
  return all_positive(d, j);
}

template <bool kGradient, bool kChanges, class M>
HWY_NOINLINE BlockSums run_one_by_one(const BatchView& batches, const M& constants,
                                      const double* HWY_RESTRICT positions,
                                      const double* HWY_RESTRICT changes,
                                      double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  const M material = constants;
  V sums[kBatchLanes / kLanes];
  for (V& v : sums) v = hn::Zero(d);
  bool admissible = true;
  for_each_vector<D>(batches, [&](size_t, size_t lane, const double* HWY_RESTRICT rest,
                                  const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    Columns<V> e;
    RecordAccess<D>::edges<kChanges>(d, positions, changes, slots, kBatchLanes, e);
    Symmetric<V> vg;
    load_rest(d, rest, vg);
    const V inverse_six_volume = load_inverse_six_volume(d, rest);
    V energy = hn::Undefined(d);
    Columns<V> gradient;
    if constexpr (TermsOf<M>::kStrain) {
      admissible &=
          evaluate_strain<kGradient>(d, material, e, vg, inverse_six_volume, energy, gradient);
    } else {
      admissible &=
          evaluate_i2<kGradient>(d, material, e, vg, inverse_six_volume, energy, gradient);
    }
    if constexpr (kGradient) {
      RecordAccess<D>::add_balanced(d, gradient, gradients, slots, kBatchLanes);
    }
    V& sum = sums[lane / kLanes];
    sum = hn::Add(sum, energy);
  });
  return {sum_of_lanes(d, sums), admissible};
}

// Laws without I₂ are computed in stages, so that the processor works on other vectors of the batch
// while it waits for the long chain of operations of one vector's logarithm.
struct Stage {
  Columns<V> evg;
  Columns<V> cofactor;
  V det;
  V j;
  V vi1;  // V I₁
};

template <bool kGradient, bool kChanges, class M>
HWY_NOINLINE BlockSums run_in_stages(const BatchView& batches, const M& constants,
                                     const double* HWY_RESTRICT positions,
                                     const double* HWY_RESTRICT changes,
                                     double* HWY_RESTRICT gradients) {
  const D d;
  constexpr size_t kLanes = hn::MaxLanes(D());
  constexpr size_t kParts = kBatchLanes / kLanes;
  constexpr size_t kTogether = kParts < 2 ? kParts : 2;
  const M material = constants;
  const V sixth = hn::Set(d, 1.0 / 6.0);
  V sums[kParts];
  for (V& v : sums) v = hn::Zero(d);
  bool admissible = true;
  for_each_vector<D, kTogether>(
      batches, [&](size_t, size_t first_lane, const double* HWY_RESTRICT rest_of_first,
                   const uint16_t* HWY_RESTRICT slots_of_first) TETRACTION_LOOP_BODY {
        Stage stages[kTogether];
        V log_j[kTogether];
        V inverse_j[kTogether];
        for (size_t i = 0; i < kTogether; ++i) {
          const double* rest = rest_of_first + i * kLanes;
          Stage& s = stages[i];
          Columns<V> e;
          RecordAccess<D>::edges<kChanges>(d, positions, changes, slots_of_first + i * kLanes,
                                           kBatchLanes, e);
          s.det = cofactors(e, s.cofactor);
          s.j = hn::Mul(s.det, load_inverse_six_volume(d, rest));
          Symmetric<V> vg;
          load_rest(d, rest, vg);
          multiply(e, vg, s.evg);
          s.vi1 = contract(e, s.evg);
        }
        for (size_t i = 0; i < kTogether; ++i) {
          log_j[i] = log_and_inverse(d, stages[i].j, inverse_j[i]);
        }
        for (size_t i = 0; i < kTogether; ++i) {
          const double* rest = rest_of_first + i * kLanes;
          const uint16_t* slots = slots_of_first + i * kLanes;
          const Stage& s = stages[i];
          admissible &= all_positive(d, s.j);
          const V inverse_volume = hn::Mul(load_inverse_six_volume(d, rest), hn::Set(d, 6.0));
          const V three_ln = hn::MulAdd(hn::Set(d, 2.0), log_j[i], hn::Set(d, 3.0));
          V first = hn::MulSub(s.vi1, inverse_volume, three_ln);
          if (HWY_UNLIKELY(!hn::AllFalse(d, hn::Lt(first, hn::Set(d, kSmallStrain))))) {
            Columns<V> e;
            RecordAccess<D>::edges<kChanges>(d, positions, changes, slots, kBatchLanes, e);
            Symmetric<V> c;
            metric(e, c);
            Symmetric<V> vg;
            load_rest(d, rest, vg);
            V second = hn::Undefined(d);
            refine<false>(d, c, vg, inverse_volume, first, second);
          }
          const Invariants<N> given{N(hn::Mul(s.vi1, inverse_volume)),
                                    N(first),
                                    N(),
                                    N(log_j[i]),
                                    N(s.j),
                                    N(s.j) - N(1.0)};
          const V volume = hn::Mul(hn::Mul(s.det, inverse_j[i]), sixth);
          V& sum = sums[first_lane / kLanes + i];
          sum = hn::MulAdd(volume, Law<M>::energy(material, given).v, sum);
          if constexpr (kGradient) {
            const auto derivatives = Law<M>::first(material, given);
            const V factor = hn::Mul(derivatives.log_j.v, hn::Mul(inverse_j[i], sixth));
            const V twice_i1 = (N(2.0) * derivatives.i1).v;
            Columns<V> gradient;
            for (int k = 0; k < 9; ++k) {
              gradient.m[k / 3][k % 3] = hn::MulAdd(factor, s.cofactor.m[k / 3][k % 3],
                                                    hn::Mul(twice_i1, s.evg.m[k / 3][k % 3]));
            }
            RecordAccess<D>::add_balanced(d, gradient, gradients, slots, kBatchLanes);
          }
        }
      });
  return {sum_of_lanes(d, sums), admissible};
}

template <bool kGradient, bool kChanges>
BlockSums run(const BatchView& batches, const IsotropicModel& model, const double* positions,
              const double* changes, double* gradients) {
  return std::visit(
      [&]<class M>(const M& material) HWY_ATTR {
        if constexpr (TermsOf<M>::kStrain || TermsOf<M>::kI2) {
          return run_one_by_one<kGradient, kChanges>(batches, material, positions, changes,
                                                     gradients);
        } else {
          return run_in_stages<kGradient, kChanges>(batches, material, positions, changes,
                                                    gradients);
        }
      },
      model);
}

BlockSums gradient_and_energy(const BatchView& batches, const IsotropicModel& material,
                              const double* positions, const double* changes, double* gradients) {
  return changes == nullptr ? run<true, false>(batches, material, positions, nullptr, gradients)
                            : run<true, true>(batches, material, positions, changes, gradients);
}
BlockSums energy_only(const BatchView& batches, const IsotropicModel& material,
                      const double* positions, const double* changes) {
  return changes == nullptr ? run<false, false>(batches, material, positions, nullptr, nullptr)
                            : run<false, true>(batches, material, positions, changes, nullptr);
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

BlockSums elastic_gradient(const BatchView& batches, const IsotropicModel& material,
                           const double* positions, const double* changes, double* gradients) {
  return HWY_DYNAMIC_DISPATCH(gradient_and_energy)(batches, material, positions, changes,
                                                   gradients);
}

BlockSums elastic_energy(const BatchView& batches, const IsotropicModel& material,
                         const double* positions, const double* changes) {
  return HWY_DYNAMIC_DISPATCH(energy_only)(batches, material, positions, changes);
}

const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace tetraction
#endif
