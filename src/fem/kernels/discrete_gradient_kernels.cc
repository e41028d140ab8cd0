#include "discrete_gradient_kernels.h"

#include <variant>

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fem/kernels/discrete_gradient_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

#include "discrete_principal-inl.h"
#include "element_parameters-inl.h"
#include "fem/discrete_stress.h"
#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

// Laws that are defined for any J: Ψ is a quadratic function of C, and there is no correction.
template <class M>
struct StrainStress {
  Real i2 = 0.0;  // Ψ₂
  Symmetric<Vec> stress;

  template <class P>
  HWY_INLINE StrainStress(const P& material, const Geometry& at, Real viscous) {
    Columns<Vec> ag = at.cg;
    for (int i = 0; i < 3; ++i) ag.m[i][i] = hn::Sub(ag.m[i][i], hn::Set(Tag(), 1.0));
    const StrainMeasures<Real> s{trace(ag), Real(0.0)};
    i2 = number(Law<M>::first_derivatives(material, s).i2);
    const Real p = Real(2.0) * Law<M>::spherical(material, s);
    Symmetric<Vec> gag;
    symmetric_product(at.g, ag, gag);
    stress = at.g;
    scale(p, stress);
    add_scaled(Real(-2.0) * i2, gag, stress);
    add_scaled(viscous, at.gdg, stress);
    scale(at.volume, stress);
  }

  template <class P>
  HWY_INLINE void derivative(const P& material, const Geometry& at, Real viscous,
                             const Symmetric<Vec>& b, Symmetric<Vec>& result) const {
    Columns<Vec> bg;
    symmetric_times(b, at.g, bg);
    Symmetric<Vec> gbg;
    symmetric_product(at.g, bg, gbg);
    // spherical() is linear in the trace.
    const Real p =
        Real(2.0) * (Law<M>::spherical(material, StrainMeasures<Real>{trace(bg), Real(0.0)}) -
                     Law<M>::spherical(material, StrainMeasures<Real>{Real(0.0), Real(0.0)}));
    result = at.g;
    scale(p, result);
    add_scaled(viscous - Real(2.0) * i2, gbg, result);
    scale(at.volume, result);
  }
};

// Laws of I₁, I₂ and J.
template <class M>
struct GeneralStress {
  static constexpr bool kI2 = TermsOf<M>::kI2;
  // Numbers of c(t).
  Real i1 = 0.0;       // I₁ at t = 0
  Real i1_rate = 0.0;  // I₁'
  Real square0 = 0.0;  // tr C² at t = 0
  Real square1 = 0.0;  // half of its rate there
  Real a1 = 0.0;       // of det c(t)
  Real a2 = 0.0;
  Real a3 = 0.0;
  Real log_j = 0.0;  // ln J and J at t = 0
  Real j = 0.0;
  Symmetric<Vec> inverse;  // c̄⁻¹
  Symmetric<Vec> gcg;      // G c̄ G
  Real factor = 0.0;       // γ
  Real square = 0.0;       // δ:GδG
  Symmetric<Vec> stress;   // s̄

  struct Point {
    Invariants<Real> s;
    Real i2_rate;     // I₂'
    Real log_j_rate;  // (ln J)'
  };

  HWY_INLINE Real i2_rate(Real t) const {
    if constexpr (!kI2) return Real(0.0);
    return mul_add(mul_add(t, i1_rate, i1), i1_rate, -mul_add(t, square, square1));
  }
  // The arguments of the law at t.
  HWY_INLINE Invariants<Real> invariants(Real t, Real log_j_there, Real j_there) const {
    const Real i1_there = mul_add(t, i1_rate, i1);
    Real i2_term(0.0);
    if constexpr (kI2) {
      const Real trace_of_square = mul_add(t, mul_add(t, square, square1 + square1), square0);
      const Real i2 = Real(0.5) * mul_sub(i1_there, i1_there, trace_of_square);
      i2_term = i2 - mul_add(Real(4.0), log_j_there, Real(3.0));
    }
    return {i1_there, i1_there - mul_add(Real(2.0), log_j_there, Real(3.0)),
            i2_term,  log_j_there,
            j_there,  j_there - Real(1.0)};
  }
  HWY_INLINE Point at(Real t) const {
    const Real ratio = mul_add(t, mul_add(t, mul_add(t, a3, a2), a1), Real(1.0));
    const Real rate = mul_add(t, mul_add(t, Real(3.0) * a3, Real(2.0) * a2), a1);
    Vec inverse_ratio;
    const Real log_ratio(log_and_inverse(Tag(), ratio.v, inverse_ratio));
    return {invariants(t, mul_add(Real(0.5), log_ratio, log_j), j * Real(hn::Sqrt(ratio.v))),
            i2_rate(t), Real(0.5) * rate * Real(inverse_ratio)};
  }
  HWY_INLINE Point middle() const {
    return {invariants(Real(0.0), log_j, j), i2_rate(Real(0.0)), Real(0.5) * a1};
  }
  // Whether the stretch is below the limit of the material at the end of the step in all lanes.
  template <class P>
  HWY_INLINE bool ends_within_limit(const P& material) const {
    const Tag tag;
    return hn::AllTrue(tag, hn::Gt(Law<M>::margin(material, at(Real(1.0)).s).v, hn::Zero(tag)));
  }
  // φ(t).
  template <class P>
  HWY_INLINE Real rate(const P& material, const Point& p) const {
    const auto first = Law<M>::first_derivatives(material, p.s);
    return mul_add(number(first.i1), i1_rate,
                   mul_add(number(first.i2), p.i2_rate, number(first.log_j) * p.log_j_rate));
  }

  template <class P>
  HWY_INLINE GeneralStress(const P& material, const Geometry& at, Real viscous) {
    const Tag tag;
    i1 = trace(at.cg);
    i1_rate = trace(at.dcg);
    symmetric_product(at.g, at.cg, gcg);
    square = at.square;
    if constexpr (kI2) {
      square0 = contract(at.c, gcg);
      square1 = contract(at.dc, gcg);
    }
    Symmetric<Vec> cofactor;
    const Real det = cofactors_of(at.c, inverse);
    const Real inverse_det = quotient(Real(1.0), det);
    scale(inverse_det, inverse);
    a1 = contract(inverse, at.dc);
    const Real det_of_change = cofactors_of(at.dc, cofactor);
    a2 = inverse_det * contract(at.c, cofactor);
    a3 = inverse_det * det_of_change;
    j = Real(hn::Sqrt(det.v)) * at.inverse_six_volume;
    Vec inverse_j;
    log_j = Real(log_and_inverse(tag, j.v, inverse_j));

    const Point middle = this->middle();
    const Real rate0 = rate(material, middle);
    Real numerator(0.0);
    const auto small = hn::Lt((a1 * a1 - Real(2.0) * a2).v, hn::Set(tag, kSmallStep * kSmallStep));
    if (!hn::AllFalse(tag, small)) {
      for (int k = 0; k < 2; ++k) {
        const Real t(kGaussPoints[k]);
        const Real pair = rate(material, this->at(t)) + rate(material, this->at(-t));
        numerator = mul_add(Real(kGaussWeights[k]), pair - (rate0 + rate0), numerator);
      }
    }
    if (HWY_UNLIKELY(!hn::AllTrue(tag, small))) {
      const Real difference = Law<M>::energy(material, this->at(Real(1.0)).s) -
                              Law<M>::energy(material, this->at(Real(-1.0)).s) - (rate0 + rate0);
      numerator = Real(hn::IfThenElse(small, numerator.v, difference.v));
    }
    const auto moves = hn::Gt(square.v, hn::Set(tag, 1e-200));
    const Real divisor(hn::IfThenElse(moves, square.v, hn::Set(tag, 1.0)));
    factor = Real(hn::IfThenElse(moves, quotient(numerator, divisor).v, hn::Zero(tag)));

    const auto first = Law<M>::first_derivatives(material, middle.s);
    stress = at.g;
    scale(Real(2.0) * mul_add(i1, number(first.i2), number(first.i1)), stress);
    if constexpr (kI2) add_scaled(Real(-2.0) * number(first.i2), gcg, stress);
    add_scaled(number(first.log_j), inverse, stress);
    add_scaled(factor + viscous, at.gdg, stress);
    scale(at.volume, stress);
  }

  // ṡ of the stress at t = 0 without the factor V, for the change b with bG and GbG.
  template <class P>
  HWY_INLINE void middle_derivative(const P& material, const Geometry& at, const Symmetric<Vec>& b,
                                    const Columns<Vec>& bg, const Symmetric<Vec>& gbg,
                                    Symmetric<Vec>& result) const {
    const Invariants<Real> s = middle().s;
    const auto first = Law<M>::first_derivatives(material, s);
    const auto second = Law<M>::second_derivatives(material, s);
    const Real d1 = trace(bg);
    Real d2(0.0);
    if constexpr (kI2) d2 = mul_sub(i1, d1, contract(b, gcg));
    const Real dl = Real(0.5) * contract(inverse, b);
    const Real first1 = mul_add(number(second.i1_i1), d1,
                                mul_add(number(second.i1_i2), d2, number(second.i1_log_j) * dl));
    const Real first_l =
        mul_add(number(second.i1_log_j), d1,
                mul_add(number(second.i2_log_j), d2, number(second.log_j_log_j) * dl));
    Real spherical = first1;
    for (Vec& v : result.m) v = hn::Zero(Tag());
    if constexpr (kI2) {
      const Real first2 = mul_add(number(second.i1_i2), d1,
                                  mul_add(number(second.i2_i2), d2, number(second.i2_log_j) * dl));
      spherical = spherical + mul_add(d1, number(first.i2), i1 * first2);
      add_scaled(Real(-2.0) * first2, gcg, result);
      add_scaled(Real(-2.0) * number(first.i2), gbg, result);
    }
    add_scaled(Real(2.0) * spherical, at.g, result);
    add_scaled(first_l, inverse, result);
    Columns<Vec> b_inverse;
    symmetric_times(b, inverse, b_inverse);
    Symmetric<Vec> product;
    symmetric_product(inverse, b_inverse, product);
    add_scaled(-number(first.log_j), product, result);
  }

  template <class P>
  HWY_INLINE void derivative(const P& material, const Geometry& at, Real viscous,
                             const Symmetric<Vec>& b, Symmetric<Vec>& result) const {
    const Tag tag;
    Columns<Vec> bg;
    symmetric_times(b, at.g, bg);
    Symmetric<Vec> gbg;
    symmetric_product(at.g, bg, gbg);
    middle_derivative(material, at, b, bg, gbg, result);
    // y:b. Both s(0):b and s(1):b are derivatives of 2Ψ.
    const Point end = this->at(Real(1.0));
    const auto first = Law<M>::first_derivatives(material, end.s);
    Symmetric<Vec> end_metric = at.c;
    add_scaled(Real(1.0), at.dc, end_metric);
    Symmetric<Vec> end_inverse;
    const Real det = cofactors_of(end_metric, end_inverse);
    scale(quotient(Real(1.0), det), end_inverse);
    const Real d1 = trace(bg);
    Real along =
        mul_add(Real(2.0) * number(first.i1), d1, number(first.log_j) * contract(end_inverse, b));
    if constexpr (kI2) {
      const Real d2 = mul_sub(end.s.i1, d1, contract(b, gcg) + contract(b, at.gdg));
      along = mul_add(Real(2.0) * number(first.i2), d2, along);
    }
    // s(0):b = (s̄/V − (γ + f) GδG):b.
    const Real change = contract(b, at.gdg);
    along = along - mul_sub(quotient(Real(1.0), at.volume), contract(stress, b),
                            (factor + viscous) * change);
    along = along - contract(result, at.dc) - Real(2.0) * factor * change;
    const auto moves = hn::Gt(square.v, hn::Set(tag, kLeastStrainChange));
    const Real divisor(hn::IfThenElse(moves, square.v, hn::Set(tag, 1.0)));
    const Real factor_rate(hn::IfThenElse(moves, quotient(along, divisor).v, hn::Zero(tag)));
    add_scaled(factor_rate, at.gdg, result);
    add_scaled(factor + viscous, gbg, result);
    scale(at.volume, result);
  }
};

template <class M>
using StressOf = std::conditional_t<
    TermsOf<M>::kStrain, StrainStress<M>,
    std::conditional_t<TermsOf<M>::kPrincipal, PrincipalStress<M>, GeneralStress<M>>>;

template <class Source>
HWY_NOINLINE bool gradient_of(const BatchView& batches, const Source& source,
                              const StepRecords& step, double* HWY_RESTRICT gradients) {
  using M = typename Source::Material;
  const Source parameters = source;
  const Real viscous(step.viscous);
  bool admissible = true;
  for_each_vector<Tag>(batches, [&](size_t batch, size_t lane, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    const auto& material = parameters.load(Tag(), batch, lane);
    const Geometry at(step, rest, slots);
    if constexpr (!TermsOf<M>::kStrain) admissible &= at.ends_admissible();
    const StressOf<M> s(material, at, viscous);
    if constexpr (HasStretchLimit<M>) admissible &= s.ends_within_limit(material);
    at.scatter(at.e, s.stress, slots, gradients);
  });
  return admissible;
}

template <class Source>
HWY_NOINLINE void product_of(const BatchView& batches, const Source& source,
                             const StepRecords& step, const double* HWY_RESTRICT directions,
                             double* HWY_RESTRICT products) {
  using M = typename Source::Material;
  const Source parameters = source;
  const Real viscous(step.viscous);
  for_each_vector<Tag>(batches, [&](size_t batch, size_t lane, const double* HWY_RESTRICT rest,
                                    const uint16_t* HWY_RESTRICT slots) TETRACTION_LOOP_BODY {
    const auto& material = parameters.load(Tag(), batch, lane);
    const Geometry at(step, rest, slots);
    Columns<Vec> direction;
    RecordAccess<Tag>::edges(Tag(), directions, slots, kBatchLanes, direction);
    Symmetric<Vec> b;
    symmetric_sum(direction, at.end(), b);
    const StressOf<M> s(material, at, viscous);
    Symmetric<Vec> rate;
    s.derivative(material, at, viscous, b, rate);
    at.scatter(direction, s.stress, slots, products);
    at.scatter(at.e, rate, slots, products);
  });
}

bool gradient(const BatchView& batches, const IsotropicModel& model, const StepRecords& step,
              double* gradients) {
  return std::visit(
      [&]<class M>(const M& material) HWY_ATTR {
        return with_parameters(batches, material, [&](const auto& parameters) HWY_ATTR {
          return gradient_of(batches, parameters, step, gradients);
        });
      },
      model);
}
void product(const BatchView& batches, const IsotropicModel& model, const StepRecords& step,
             const double* directions, double* products) {
  std::visit(
      [&]<class M>(const M& material) HWY_ATTR {
        with_parameters(batches, material, [&](const auto& parameters) HWY_ATTR {
          product_of(batches, parameters, step, directions, products);
        });
      },
      model);
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(gradient);
HWY_EXPORT(product);

bool add_discrete_gradient(const BatchView& batches, const IsotropicModel& material,
                           const StepRecords& step, double* gradients) {
  return HWY_DYNAMIC_DISPATCH(gradient)(batches, material, step, gradients);
}

void add_discrete_gradient_product(const BatchView& batches, const IsotropicModel& material,
                                   const StepRecords& step, const double* directions,
                                   double* products) {
  HWY_DYNAMIC_DISPATCH(product)(batches, material, step, directions, products);
}

}  // namespace tetraction
#endif
