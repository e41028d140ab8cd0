// The state of elements that the tangent kernels store. Highway includes this file once for each instruction
// set.
#if defined(TETRACTION_FEM_TANGENT_STATE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_TANGENT_STATE_INL_H_
#undef TETRACTION_FEM_TANGENT_STATE_INL_H_
#else
#define TETRACTION_FEM_TANGENT_STATE_INL_H_
#endif

#include "element_parameters-inl.h"
#include "material/laws/laws-inl.h"
#include "simd_records-inl.h"
#include "tangent_kernels.h"
#include "tangent_principal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

// The form of the stiffness of a material without viscosity.
template <class M>
constexpr TangentForm form_of() {
  using Terms = TermsOf<M>;
  if constexpr (Terms::kStrain) {
    return TangentForm::kMetric;
  } else {
    TangentForm form = TangentForm::kSpatial;
    if (Terms::kPrincipal) form = form | TangentForm::kPrincipal;
    if (Terms::kI2) form = form | TangentForm::kMetric;
    if (Terms::kI1Coupled) form = form | TangentForm::kCoupled;
    if (Terms::kI2Coupled) form = form | TangentForm::kCoupledI2;
    return form;
  }
}

// factor × volume × derivative.
template <class Real, class T>
HWY_INLINE Real scaled(double factor, Real volume, T derivative) {
  if constexpr (kIsZero<T>) {
    return Real(0.0);
  } else {
    return volume * (Real(factor) * derivative);
  }
}

// Computes the state of all elements at `positions` (tangent_kernels.h).
template <TangentForm kForm, class Source, class T>
HWY_NOINLINE void prepare(const BatchView& batches, const Source& source,
                          const double* HWY_RESTRICT positions, T* HWY_RESTRICT state) {
  using M = typename Source::Material;
  using Real = Number<DoubleTag>;
  using Terms = TermsOf<M>;
  const DoubleTag tag;
  const Source parameters = source;
  for_each_vector<DoubleTag>(batches, [&](size_t b, size_t lane, const double* HWY_RESTRICT rest,
                                          const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    const auto& material = parameters.load(tag, b, lane);
    Columns<DoubleVec> e;
    RecordAccess<DoubleTag>::edges(tag, positions, slots, kBatchLanes, e);
    Symmetric<DoubleVec> vg;
    for (size_t k = 0; k < 6; ++k) vg.m[k] = hn::Load(tag, rest + k * kBatchLanes);
    const DoubleVec inverse_six_volume = hn::Load(tag, rest + 6 * kBatchLanes);
    const DoubleVec inverse_volume = hn::Mul(inverse_six_volume, hn::Set(tag, 6.0));
    const Real volume(hn::Div(hn::Set(tag, 1.0), inverse_volume));
    Symmetric<DoubleVec> c;
    metric(e, c);
    Columns<DoubleVec> cvg;
    symmetric_times(c, vg, cvg);
    Symmetric<DoubleVec> gcg;  // V² G c G
    symmetric_product(vg, cvg, gcg);
    const DoubleVec i1 =
        hn::Mul(hn::Add(cvg.m[0][0], hn::Add(cvg.m[1][1], cvg.m[2][2])), inverse_volume);

    StateWriter<T> write(state + tangent_numbers(kForm) * kBatchLanes * b + lane);
    Symmetric<DoubleVec> stress;
    Real a1 = 0.0;
    Real a2 = 0.0;
    const auto write_metric = [&]() HWY_ATTR {
      for (int k = 0; k < 9; ++k) write.put(e.m[k / 3][k % 3]);
      for (int k = 0; k < 6; ++k) write.put(hn::Mul(vg.m[k], inverse_volume));
      write.put(a1.v);
      write.put(a2.v);
    };
    if constexpr (Terms::kStrain) {
      const StrainMeasures<Real> given{Real(i1) - Real(3.0), Real(0.0)};
      const Real twice_i2 = Real(2.0) * Law<M>::first_derivatives(material, given).i2;
      // G a G = G c G − G.
      const DoubleVec forward = hn::Mul((-twice_i2).v, inverse_volume);
      const DoubleVec p = (Real(2.0) * Law<M>::spherical(material, given) + twice_i2).v;
      for (int k = 0; k < 6; ++k) {
        stress.m[k] = hn::MulAdd(forward, gcg.m[k], hn::Mul(p, vg.m[k]));
      }
      a1 = -twice_i2 * volume;
      a2 = (twice_i2 + Real(2.0) * Law<M>::second_derivatives(material, given).i1_i1) * volume;
      for (int k = 0; k < 6; ++k) write.put(stress.m[k]);
      write_metric();
    } else {
      Columns<DoubleVec> w;
      const DoubleVec det = cofactors(e, w);
      const DoubleVec j = hn::Mul(det, inverse_six_volume);
      DoubleVec inverse_det;
      const Real log_j(log_and_inverse(tag, j, inverse_det));
      inverse_det = hn::Mul(inverse_det, inverse_six_volume);
      DoubleVec square = hn::Zero(tag);  // V² tr C²
      if constexpr (Terms::kI2) square = trace_of_square(tag, cvg);
      const DoubleVec i2 =
          hn::Mul(hn::Set(tag, 0.5),
                  hn::NegMulAdd(square, hn::Mul(inverse_volume, inverse_volume), hn::Mul(i1, i1)));
      const Invariants<Real> given{Real(i1),
                                   Real(i1) - mul_add(Real(2.0), log_j, Real(3.0)),
                                   Real(i2) - mul_add(Real(4.0), log_j, Real(3.0)),
                                   log_j,
                                   Real(j),
                                   Real(j) - Real(1.0)};
      const auto first = first_derivatives<M>(material, given);
      const auto second = second_derivatives<M>(material, given);
      const auto principal = principal_terms<M>(tag, material, e, vg, inverse_volume, volume);
      const Real twice_i1 = Real(2.0) * first.i1;
      if constexpr (Terms::kI2) {
        const Real twice_i2 = Real(2.0) * first.i2;
        const DoubleVec scale = hn::MulAdd(twice_i2.v, i1, twice_i1.v);
        const DoubleVec back = hn::Mul(twice_i2.v, inverse_volume);
        for (int k = 0; k < 6; ++k) {
          stress.m[k] = hn::NegMulAdd(back, gcg.m[k], hn::Mul(scale, vg.m[k]));
        }
        a1 = -(twice_i2 * volume);
        a2 = twice_i2 * volume + scaled(2.0, volume, second.i1_i1);
      } else if constexpr (Terms::kPrincipal) {
        stress = principal.stress;
      } else {
        for (int k = 0; k < 6; ++k) stress.m[k] = hn::Mul(twice_i1.v, vg.m[k]);
      }
      for (int k = 0; k < 6; ++k) write.put(stress.m[k]);
      for (int k = 0; k < 9; ++k) write.put(hn::Mul(w.m[k / 3][k % 3], inverse_det));
      DoubleVec tension = hn::Zero(tag);  // t v
      if (batches.tensions != nullptr) {
        tension = hn::Mul(hn::Load(tag, batches.tensions + b * kBatchLanes + lane),
                          hn::Mul(det, hn::Set(tag, 1.0 / 6.0)));
      }
      write.put(hn::Sub((-(volume * first.log_j)).v, tension));
      // Ψ₁₁ of a law with a limit of Ī₁ may be so large that the derivatives of I₁ and of ln J cancel in single
      // precision. Such a law has z = F G − I₁/3 F⁻ᵀ, the derivative of Ī₁ but for a factor, in place of F G.
      DoubleVec third = hn::Zero(tag);  // I₁/3
      if constexpr (HasStretchLimit<M>) third = hn::Mul(i1, hn::Set(tag, 1.0 / 3.0));
      Real log_j_log_j = scaled(1.0, volume, second.log_j_log_j);
      if constexpr (HasStretchLimit<M>) {
        const Real a(third);
        log_j_log_j = log_j_log_j + Real(4.0) * a * volume * (second.i1_log_j + a * second.i1_i1);
      }
      write.put(hn::Add(log_j_log_j.v, tension));
      if constexpr (has(kForm, TangentForm::kMetric)) write_metric();
      if constexpr (has(kForm, TangentForm::kCoupled)) {
        Columns<DoubleVec> z;
        multiply(e, vg, z);
        for (int k = 0; k < 9; ++k) {
          DoubleVec number = hn::Mul(z.m[k / 3][k % 3], inverse_volume);
          if constexpr (HasStretchLimit<M>) {
            number = hn::NegMulAdd(third, hn::Mul(w.m[k / 3][k % 3], inverse_det), number);
          }
          write.put(number);
        }
        if constexpr (Terms::kI2) {
          write.put(hn::Zero(tag));  // Ψ₁₁ is in a₂
        } else {
          write.put(scaled(4.0, volume, second.i1_i1).v);
        }
        if constexpr (HasStretchLimit<M>) {
          write.put(
              (Real(2.0) * volume * (second.i1_log_j + Real(2.0) * Real(third) * second.i1_i1)).v);
        } else {
          write.put(scaled(2.0, volume, second.i1_log_j).v);
        }
      }
      if constexpr (has(kForm, TangentForm::kCoupledI2)) {
        Symmetric<DoubleVec> inner;  // I₁ G − G c G
        for (int k = 0; k < 6; ++k) {
          inner.m[k] = hn::Mul(inverse_volume,
                               hn::NegMulAdd(inverse_volume, gcg.m[k], hn::Mul(i1, vg.m[k])));
        }
        Columns<DoubleVec> gradient;
        multiply(e, inner, gradient);
        for (int k = 0; k < 9; ++k) write.put(gradient.m[k / 3][k % 3]);
        write.put(scaled(4.0, volume, second.i2_i2).v);
        write.put(scaled(4.0, volume, second.i1_i2).v);
        write.put(scaled(2.0, volume, second.i2_log_j).v);
      }
      if constexpr (Terms::kPrincipal) principal.write(write);
    }
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
