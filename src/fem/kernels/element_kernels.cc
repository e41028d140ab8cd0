#include "element_kernels.h"

#include <variant>

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/element_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "element_parameters-inl.h"
#include "element_values.h"
#include "material/laws/laws-inl.h"
#include "principal-inl.h"
#include "simd_records-inl.h"
#include "strain_invariants-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Real = Number<Tag>;

// Loads V G of the elements in the lanes.
HWY_INLINE void load_rest(Tag tag, const double* HWY_RESTRICT rest, Symmetric<Vec>& vg) {
  for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(tag, rest + k * kBatchLanes);
}
HWY_INLINE Vec load_inverse_six_volume(Tag tag, const double* HWY_RESTRICT rest) {
  return hn::Load(tag, rest + 6 * kBatchLanes);
}

// Where J is positive and finite.
HWY_INLINE hn::Mask<Tag> positive(Tag tag, Vec j) {
  return hn::And(hn::Gt(j, hn::Zero(tag)), hn::Lt(j, hn::Set(tag, 1e300)));
}
HWY_INLINE bool all_positive(Tag tag, Vec j) {
  return hn::AllTrue(tag, positive(tag, j));
}

// What a loop over elements stores besides the sum of their energies: nothing, their gradients in records, or the
// values of element_values().
enum class Output { kNothing, kGradients, kValues };

// Stores Ψ, which is 0 where it is not defined, and
//
//     σ = Σ_k g_k e_kᵀ/v,   v = det e/6,
//
// with the gradients g_k = ∂W/∂e_k. This is the virial: ∂W/∂e = V P D_m⁻ᵀ, P Fᵀ = J σ and e = F D_m.
HWY_INLINE void store_values(Tag tag, hn::Mask<Tag> defined, Vec energy_density,
                             const Columns<Vec>& e, Vec det, const Columns<Vec>& gradient,
                             double* HWY_RESTRICT to) {
  const Vec finite = hn::Sub(energy_density, energy_density);  // 0, or not a number
  const auto keeps = hn::And(defined, hn::Eq(finite, hn::Zero(tag)));
  hn::Store(hn::IfThenElseZero(keeps, energy_density), tag, to);
  const Vec inverse_volume = hn::Div(hn::Set(tag, 6.0), det);
  constexpr int kEntries[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
  for (const auto& [i, j] : kEntries) {
    to += kBatchLanes;
    const Vec sum =
        hn::MulAdd(gradient.m[2][i], e.m[2][j],
                   hn::MulAdd(gradient.m[1][i], e.m[1][j], hn::Mul(gradient.m[0][i], e.m[0][j])));
    hn::Store(hn::Mul(sum, inverse_volume), tag, to);
  }
}

// Energy and ∂W/∂e of the elements in the lanes for a law that is defined for any J. Returns whether
// all numbers are finite.
template <bool kGradient, class M, class P>
HWY_INLINE bool evaluate_strain(Tag tag, const P& material, const Columns<Vec>& e,
                                const Symmetric<Vec>& vg, Vec inverse_six_volume, Vec& energy,
                                Columns<Vec>& gradient) {
  const Vec inverse_volume = hn::Mul(inverse_six_volume, hn::Set(tag, 6.0));
  Symmetric<Vec> c;
  metric(e, c);
  Columns<Vec> ag;
  strain(tag, c, vg, inverse_volume, ag);
  const Vec tr = trace(ag);
  const StrainMeasures<Real> s{Real(tr), Real(trace_of_square(tag, ag))};
  energy = hn::Div(Law<M>::energy(material, s).v, inverse_volume);
  if constexpr (kGradient) {
    const Vec minus = (Real(-2.0) * Law<M>::first_derivatives(material, s).i2).v;
    const Vec p = (Real(2.0) * Law<M>::spherical(material, s)).v;
    Symmetric<Vec> stress;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        const Vec gag = hn::MulAdd(vg(i, 2), ag.m[j][2],
                                   hn::MulAdd(vg(i, 1), ag.m[j][1], hn::Mul(vg(i, 0), ag.m[j][0])));
        stress(i, j) = hn::MulAdd(minus, gag, hn::Mul(p, vg(i, j)));
      }
    }
    multiply(e, stress, gradient);
  }
  // x − x is 0 for a finite x only.
  return hn::AllTrue(tag, hn::Eq(hn::Sub(tr, tr), hn::Zero(tag)));
}

// The tensions of the elements in the lanes.
HWY_INLINE Vec load_tension(Tag tag, const double* HWY_RESTRICT tensions, size_t batch,
                            size_t lane) {
  return tensions == nullptr ? hn::Zero(tag) : hn::Load(tag, tensions + batch * kBatchLanes + lane);
}

// Energy and ∂W/∂e of the elements in the lanes for a law that depends on I₂ and needs J > 0.
// Returns whether J > 0 and all numbers are finite.
template <bool kGradient, class M, class P>
HWY_INLINE bool evaluate_i2(Tag tag, const P& material, const Columns<Vec>& e,
                            const Symmetric<Vec>& vg, Vec inverse_six_volume, Vec tension,
                            Vec& energy, Columns<Vec>& gradient) {
  const Vec inverse_volume = hn::Mul(inverse_six_volume, hn::Set(tag, 6.0));
  Columns<Vec> cofactor;
  const Vec det = cofactors(e, cofactor);
  const Vec j = hn::Mul(det, inverse_six_volume);
  Vec inverse_j;
  const Vec log_j = log_and_inverse(tag, j, inverse_j);
  const Vec volume = hn::Mul(hn::Mul(det, inverse_j), hn::Set(tag, 1.0 / 6.0));
  Columns<Vec> evg;
  multiply(e, vg, evg);
  const Vec vi1 = contract(e, evg);  // V I₁
  const Vec i1 = hn::Mul(vi1, inverse_volume);
  Symmetric<Vec> c;
  metric(e, c);
  Columns<Vec> cvg;  // c V G, by columns
  symmetric_times(c, vg, cvg);
  Symmetric<Vec> gcvg;  // V G c G
  symmetric_product(vg, cvg, gcvg);
  for (Vec& number : gcvg.m) number = hn::Mul(number, inverse_volume);

  Vec i1_term = hn::Sub(i1, hn::MulAdd(hn::Set(tag, 2.0), log_j, hn::Set(tag, 3.0)));
  // I₂ = ½ (I₁² − tr C²), tr C² = c:(G c G).
  Vec square = hn::Zero(tag);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) square = hn::MulAdd(c(i, k), gcvg(i, k), square);
  }
  const Vec half = hn::Set(tag, 0.5);
  Vec i2 = hn::Mul(half, hn::MulSub(i1, i1, hn::Mul(square, inverse_volume)));
  const auto far = hn::Gt(i1, hn::Set(tag, kLargeStretch));
  if (HWY_UNLIKELY(!hn::AllFalse(tag, far))) {
    i2 = hn::IfThenElse(far, second_invariant(cofactor, vg, inverse_volume), i2);
  }
  Vec i2_term = hn::Sub(i2, hn::MulAdd(hn::Set(tag, 4.0), log_j, hn::Set(tag, 3.0)));
  if (HWY_UNLIKELY(!hn::AllFalse(tag, hn::Lt(i1_term, hn::Set(tag, kSmallStrain))))) {
    refine<true>(tag, cvg, volume, inverse_volume, j, log_j, i1_term, i2_term);
  }
  const Invariants<Real> s{Real(i1),    Real(i1_term), Real(i2_term),
                           Real(log_j), Real(j),       Real(j) - Real(1.0)};
  if constexpr (kGradient) {
    const auto derivatives = Law<M>::first_derivatives(material, s);
    // Ψ_L V/det e + t/6
    const Vec factor =
        hn::Mul(hn::MulAdd(derivatives.log_j.v, inverse_j, tension), hn::Set(tag, 1.0 / 6.0));
    // V [2 (Ψ₁ + Ψ₂ I₁) G − 2 Ψ₂ G c G]
    const Vec twice_i2 = (Real(2.0) * derivatives.i2).v;
    const Vec scale = hn::MulAdd(twice_i2, i1, (Real(2.0) * derivatives.i1).v);
    Symmetric<Vec> stress;
    for (int k = 0; k < 6; ++k) {
      stress.m[k] = hn::NegMulAdd(twice_i2, gcvg.m[k], hn::Mul(scale, vg.m[k]));
    }
    multiply(e, stress, gradient);
    for (int k = 0; k < 9; ++k) {
      gradient.m[k / 3][k % 3] =
          hn::MulAdd(factor, cofactor.m[k / 3][k % 3], gradient.m[k / 3][k % 3]);
    }
  }
  energy = hn::Mul(volume, Law<M>::energy(material, s).v);
  return all_positive(tag, j);
}

// The same for a law in principal stretches.
template <bool kGradient, class M, class P>
HWY_INLINE bool evaluate_principal(Tag tag, const P& material, const Columns<Vec>& e,
                                   const Symmetric<Vec>& vg, Vec inverse_six_volume, Vec tension,
                                   Vec& energy, Columns<Vec>& gradient) {
  const Vec inverse_volume = hn::Mul(inverse_six_volume, hn::Set(tag, 6.0));
  Columns<Vec> cofactor;
  const Vec det = cofactors(e, cofactor);
  const Vec j = hn::Mul(det, inverse_six_volume);
  const Vec inverse_j = hn::Div(hn::Set(tag, 1.0), j);
  Symmetric<Vec> g;
  for (int k = 0; k < 6; ++k) g.m[k] = hn::Mul(vg.m[k], inverse_volume);
  const auto frame = PrincipalFrame<Tag>::of_edges(tag, e, g);
  // The quadratic part uses J and J − 1 only.
  const Real zero(0.0);
  const Invariants<Real> s{zero, zero, zero, zero, Real(j), Real(j) - Real(1.0)};
  const Volumetric<Real> volumetric(VolumetricPart::kQuadratic, s);
  const Real volume = Real(1.0) / Real(inverse_volume);
  if constexpr (kGradient) {
    // Ψ_L V/det e + t/6
    const Real slope = Real(material.kappa) * volumetric.first_derivative;
    const Vec factor = hn::Mul(hn::MulAdd(slope.v, inverse_j, tension), hn::Set(tag, 1.0 / 6.0));
    Real principal[3];
    frame.stretches.template stress<Law<M>>(material, principal);
    Symmetric<Vec> stress;
    frame.stress(principal, volume, stress);
    multiply(e, stress, gradient);
    for (int k = 0; k < 9; ++k) {
      gradient.m[k / 3][k % 3] =
          hn::MulAdd(factor, cofactor.m[k / 3][k % 3], gradient.m[k / 3][k % 3]);
    }
  }
  energy = (volume * mul_add(Real(material.kappa), volumetric.energy,
                             frame.stretches.template energy<Law<M>>(material)))
               .v;
  return all_positive(tag, j);
}

template <Output kOutput, bool kHasDisplacements, class Source>
HWY_NOINLINE BlockSums run_vector_by_vector(const BatchView& batches, const Source& source,
                                            const double* HWY_RESTRICT positions,
                                            const double* HWY_RESTRICT displacements,
                                            double* HWY_RESTRICT output) {
  using M = typename Source::Material;
  constexpr bool kGradient = kOutput != Output::kNothing;
  const Tag tag;
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  const Source parameters = source;
  Vec sums[kBatchLanes / kLanes];
  for (Vec& v : sums) v = hn::Zero(tag);
  bool admissible = true;
  for_each_vector<Tag>(batches, [&](size_t batch, size_t lane, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    const auto& material = parameters.load(tag, batch, lane);
    Columns<Vec> e;
    RecordAccess<Tag>::edges<kHasDisplacements>(tag, positions, displacements, slots, kBatchLanes,
                                                e);
    Symmetric<Vec> vg;
    load_rest(tag, rest, vg);
    const Vec inverse_six_volume = load_inverse_six_volume(tag, rest);
    Vec energy = hn::Undefined(tag);
    Columns<Vec> gradient;
    if constexpr (TermsOf<M>::kStrain) {
      admissible &=
          evaluate_strain<kGradient, M>(tag, material, e, vg, inverse_six_volume, energy, gradient);
    } else if constexpr (TermsOf<M>::kPrincipal) {
      admissible &= evaluate_principal<kGradient, M>(
          tag, material, e, vg, inverse_six_volume,
          load_tension(tag, batches.tensions, batch, lane), energy, gradient);
    } else {
      admissible &= evaluate_i2<kGradient, M>(tag, material, e, vg, inverse_six_volume,
                                              load_tension(tag, batches.tensions, batch, lane),
                                              energy, gradient);
    }
    if constexpr (kOutput == Output::kGradients) {
      RecordAccess<Tag>::add_balanced(tag, gradient, output, slots, kBatchLanes);
    } else if constexpr (kOutput == Output::kValues) {
      Columns<Vec> unused;
      const Vec det = cofactors(e, unused);
      const auto defined =
          TermsOf<M>::kStrain ? hn::Eq(det, det) : positive(tag, hn::Mul(det, inverse_six_volume));
      const Vec density = hn::Mul(energy, hn::Mul(inverse_six_volume, hn::Set(tag, 6.0)));
      store_values(tag, defined, density, e, det, gradient,
                   output + batch * kValueNumbers * kBatchLanes + lane);
    }
    Vec& sum = sums[lane / kLanes];
    sum = hn::Add(sum, energy);
  });
  return {sum_of_lanes(tag, sums), admissible};
}

// Intermediate results of a law without I₂. Such laws are computed in stages, each for several
// vectors of a batch. The processor can then work on one vector while it waits for the long chain
// of operations in the logarithm of another.
struct Stage {
  Columns<Vec> e;
  Columns<Vec> evg;
  Columns<Vec> cofactor;
  Vec det;
  Vec j;
  Vec vi1;  // V I₁
};

template <Output kOutput, bool kHasDisplacements, class Source>
HWY_NOINLINE BlockSums run_in_stages(const BatchView& batches, const Source& source,
                                     const double* HWY_RESTRICT positions,
                                     const double* HWY_RESTRICT displacements,
                                     double* HWY_RESTRICT output) {
  using M = typename Source::Material;
  const Tag tag;
  constexpr size_t kLanes = hn::MaxLanes(Tag());
  constexpr size_t kParts = kBatchLanes / kLanes;
  constexpr size_t kTogether = kParts < 2 ? kParts : 2;
  const Source parameters = source;
  const Vec sixth = hn::Set(tag, 1.0 / 6.0);
  Vec sums[kParts];
  for (Vec& v : sums) v = hn::Zero(tag);
  bool admissible = true;
  for_each_vector<Tag, kTogether>(
      batches, [&](size_t batch, size_t first_lane, const double* HWY_RESTRICT rest_of_first,
                   const uint16_t* HWY_RESTRICT slots_of_first) TETRACTION_LOOP_BODY {
        Stage stages[kTogether];
        Vec log_j[kTogether];
        Vec inverse_j[kTogether];
        for (size_t i = 0; i < kTogether; ++i) {
          const double* rest = rest_of_first + i * kLanes;
          Stage& s = stages[i];
          RecordAccess<Tag>::edges<kHasDisplacements>(
              tag, positions, displacements, slots_of_first + i * kLanes, kBatchLanes, s.e);
          s.det = cofactors(s.e, s.cofactor);
          s.j = hn::Mul(s.det, load_inverse_six_volume(tag, rest));
          Symmetric<Vec> vg;
          load_rest(tag, rest, vg);
          multiply(s.e, vg, s.evg);
          s.vi1 = contract(s.e, s.evg);
        }
        for (size_t i = 0; i < kTogether; ++i) {
          log_j[i] = log_and_inverse(tag, stages[i].j, inverse_j[i]);
        }
        for (size_t i = 0; i < kTogether; ++i) {
          const auto& material = parameters.load(tag, batch, first_lane + i * kLanes);
          const double* rest = rest_of_first + i * kLanes;
          const uint16_t* slots = slots_of_first + i * kLanes;
          const Stage& s = stages[i];
          const Vec inverse_volume = hn::Mul(load_inverse_six_volume(tag, rest), hn::Set(tag, 6.0));
          const Vec volume = hn::Mul(hn::Mul(s.det, inverse_j[i]), sixth);
          const Vec offset = hn::MulAdd(hn::Set(tag, 2.0), log_j[i], hn::Set(tag, 3.0));
          Vec i1_term = hn::MulSub(s.vi1, inverse_volume, offset);
          if (HWY_UNLIKELY(!hn::AllFalse(tag, hn::Lt(i1_term, hn::Set(tag, kSmallStrain))))) {
            Symmetric<Vec> c;
            metric(s.e, c);
            Symmetric<Vec> vg;
            load_rest(tag, rest, vg);
            Columns<Vec> cvg;
            symmetric_times(c, vg, cvg);
            Vec unused_i2_term = hn::Undefined(tag);
            refine<false>(tag, cvg, volume, inverse_volume, s.j, log_j[i], i1_term, unused_i2_term);
          }
          const Invariants<Real> given{Real(hn::Mul(s.vi1, inverse_volume)),
                                       Real(i1_term),
                                       Real(),
                                       Real(log_j[i]),
                                       Real(s.j),
                                       Real(s.j) - Real(1.0)};
          auto defined = positive(tag, s.j);
          if constexpr (HasStretchLimit<M>) {
            const Vec margin = Law<M>::margin(material, given).v;
            defined = hn::And(defined, hn::Gt(margin, hn::Zero(tag)));
          }
          admissible &= hn::AllTrue(tag, defined);
          Vec& sum = sums[first_lane / kLanes + i];
          const Vec density = Law<M>::energy(material, given).v;
          sum = hn::MulAdd(volume, density, sum);
          if constexpr (kOutput != Output::kNothing) {
            const auto derivatives = Law<M>::first_derivatives(material, given);
            const Vec tension = load_tension(tag, batches.tensions, batch, first_lane + i * kLanes);
            const Vec factor =
                hn::Mul(hn::MulAdd(derivatives.log_j.v, inverse_j[i], tension), sixth);
            const Vec twice_i1 = (Real(2.0) * derivatives.i1).v;
            Columns<Vec> gradient;
            for (int k = 0; k < 9; ++k) {
              gradient.m[k / 3][k % 3] = hn::MulAdd(factor, s.cofactor.m[k / 3][k % 3],
                                                    hn::Mul(twice_i1, s.evg.m[k / 3][k % 3]));
            }
            if constexpr (kOutput == Output::kGradients) {
              RecordAccess<Tag>::add_balanced(tag, gradient, output, slots, kBatchLanes);
            } else {
              store_values(tag, defined, density, s.e, s.det, gradient,
                           output + batch * kValueNumbers * kBatchLanes + first_lane + i * kLanes);
            }
          }
        }
      });
  return {sum_of_lanes(tag, sums), admissible};
}

template <Output kOutput, bool kHasDisplacements>
BlockSums run(const BatchView& batches, const IsotropicModel& model, const double* positions,
              const double* displacements, double* output) {
  return std::visit(
      [&]<class M>(const M& material) HWY_ATTR {
        return with_parameters(batches, material, [&](const auto& parameters) HWY_ATTR {
          if constexpr (TermsOf<M>::kStrain || TermsOf<M>::kI2 || TermsOf<M>::kPrincipal) {
            return run_vector_by_vector<kOutput, kHasDisplacements>(batches, parameters, positions,
                                                                    displacements, output);
          } else {
            return run_in_stages<kOutput, kHasDisplacements>(batches, parameters, positions,
                                                             displacements, output);
          }
        });
      },
      model);
}

BlockSums gradient_and_energy(const BatchView& batches, const IsotropicModel& material,
                              const double* positions, const double* displacements,
                              double* gradients) {
  return displacements == nullptr
             ? run<Output::kGradients, false>(batches, material, positions, nullptr, gradients)
             : run<Output::kGradients, true>(batches, material, positions, displacements,
                                             gradients);
}
BlockSums energy_only(const BatchView& batches, const IsotropicModel& material,
                      const double* positions, const double* displacements) {
  return displacements == nullptr
             ? run<Output::kNothing, false>(batches, material, positions, nullptr, nullptr)
             : run<Output::kNothing, true>(batches, material, positions, displacements, nullptr);
}
void values(const BatchView& batches, const IsotropicModel& material, const double* positions,
            double* output) {
  run<Output::kValues, false>(batches, material, positions, nullptr, output);
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
HWY_EXPORT(values);
HWY_EXPORT(target_name);

BlockSums elastic_gradient(const BatchView& batches, const IsotropicModel& material,
                           const double* positions, const double* displacements,
                           double* gradients) {
  return HWY_DYNAMIC_DISPATCH(gradient_and_energy)(batches, material, positions, displacements,
                                                   gradients);
}

BlockSums elastic_energy(const BatchView& batches, const IsotropicModel& material,
                         const double* positions, const double* displacements) {
  return HWY_DYNAMIC_DISPATCH(energy_only)(batches, material, positions, displacements);
}

void element_values(const BatchView& batches, const IsotropicModel& material,
                    const double* positions, double* output) {
  HWY_DYNAMIC_DISPATCH(values)(batches, material, positions, output);
}

const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(target_name)();
}

}  // namespace tetraction
#endif
