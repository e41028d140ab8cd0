// The arithmetic that material laws use, for a double and for a vector of numbers. Highway includes
// this file once for each instruction set.
#if defined(TETRACTION_MATERIAL_NUMBER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_NUMBER_INL_H_
#undef TETRACTION_MATERIAL_NUMBER_INL_H_
#else
#define TETRACTION_MATERIAL_NUMBER_INL_H_
#endif

#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <cmath>
#include <cstddef>
#include <limits>

#include "derivatives.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A vector with one number in each lane and the usual operators. A constant is copied to all lanes.
template <class Tag>
struct Number {
  hn::Vec<Tag> v;

  // Zero instead of an undefined value, which compilers warn of where they see no use of it.
  HWY_INLINE Number() : v(hn::Zero(Tag())) {}
  HWY_INLINE Number(double constant)  // NOLINT(google-explicit-constructor)
      : v(hn::Set(Tag(), static_cast<hn::TFromD<Tag>>(constant))) {}
  HWY_INLINE explicit Number(hn::Vec<Tag> vector) : v(vector) {}

  friend HWY_INLINE Number operator+(Number a, Number b) { return Number(hn::Add(a.v, b.v)); }
  friend HWY_INLINE Number operator-(Number a, Number b) { return Number(hn::Sub(a.v, b.v)); }
  friend HWY_INLINE Number operator*(Number a, Number b) { return Number(hn::Mul(a.v, b.v)); }
  friend HWY_INLINE Number operator/(Number a, Number b) { return Number(hn::Div(a.v, b.v)); }
  friend HWY_INLINE Number operator-(Number a) { return Number(hn::Neg(a.v)); }
};

/// a b + c, rounded only once if the processor has fused multiplication and addition.
template <class Tag>
HWY_INLINE Number<Tag> mul_add(Number<Tag> a, Number<Tag> b, Number<Tag> c) {
  return Number<Tag>(hn::MulAdd(a.v, b.v, c.v));
}
HWY_INLINE double mul_add(double a, double b, double c) {
  return a * b + c;
}
/// a b − c.
template <class Tag>
HWY_INLINE Number<Tag> mul_sub(Number<Tag> a, Number<Tag> b, Number<Tag> c) {
  return Number<Tag>(hn::MulSub(a.v, b.v, c.v));
}
HWY_INLINE double mul_sub(double a, double b, double c) {
  return a * b - c;
}
/// `value`, an exponential of x, or infinity beyond 706, up to where Highway's exponentials are defined.
template <class Tag>
HWY_INLINE Number<Tag> or_infinity(Number<Tag> x, hn::Vec<Tag> value) {
  constexpr hn::TFromD<Tag> kLargest = 706.0;
  constexpr auto kInfinity = std::numeric_limits<hn::TFromD<Tag>>::infinity();
  const Tag tag;
  return Number<Tag>(
      hn::IfThenElse(hn::Gt(x.v, hn::Set(tag, kLargest)), hn::Set(tag, kInfinity), value));
}
/// eˣ.
template <class Tag>
HWY_INLINE Number<Tag> exponential(Number<Tag> x) {
  return or_infinity(x, hn::Exp(Tag(), x.v));
}
HWY_INLINE double exponential(double x) {
  return std::exp(x);
}
/// eˣ − 1 and ln(1 + x), which keep their digits near x = 0.
template <class Tag>
HWY_INLINE Number<Tag> exponential_minus_1(Number<Tag> x) {
  return or_infinity(x, hn::Expm1(Tag(), x.v));
}
HWY_INLINE double exponential_minus_1(double x) {
  return std::expm1(x);
}
template <class Tag>
HWY_INLINE Number<Tag> log_of_1_plus(Number<Tag> x) {
  return Number<Tag>(hn::Log1p(Tag(), x.v));
}
HWY_INLINE double log_of_1_plus(double x) {
  return std::log1p(x);
}
template <class Tag>
HWY_INLINE Number<Tag> square_root(Number<Tag> x) {
  return Number<Tag>(hn::Sqrt(x.v));
}
HWY_INLINE double square_root(double x) {
  return std::sqrt(x);
}
/// The larger of |x| and |y|.
template <class Tag>
HWY_INLINE Number<Tag> larger_magnitude(Number<Tag> x, Number<Tag> y) {
  return Number<Tag>(hn::Max(hn::Abs(x.v), hn::Abs(y.v)));
}
HWY_INLINE double larger_magnitude(double x, double y) {
  return std::fmax(std::abs(x), std::abs(y));
}
/// Whether the largest of three numbers is above `factor` times the smallest, in any lane.
template <class Tag>
HWY_INLINE bool differ_by(double factor, const Number<Tag>* x) {
  const auto least = hn::Min(x[0].v, hn::Min(x[1].v, x[2].v));
  const auto most = hn::Max(x[0].v, hn::Max(x[1].v, x[2].v));
  return !hn::AllFalse(Tag(), hn::Gt(most, hn::Mul(Number<Tag>(factor).v, least)));
}
HWY_INLINE bool differ_by(double factor, const double* x) {
  return std::fmax(x[0], std::fmax(x[1], x[2])) > factor * std::fmin(x[0], std::fmin(x[1], x[2]));
}
/// Copies the numbers in the lanes of x to memory or from there.
template <class Tag>
HWY_INLINE void to_lanes(Number<Tag> x, double* lanes) {
  hn::StoreU(x.v, Tag(), lanes);
}
HWY_INLINE void to_lanes(double x, double* lanes) {
  *lanes = x;
}
template <class Tag>
HWY_INLINE void from_lanes(const double* lanes, Number<Tag>& x) {
  x = Number<Tag>(hn::LoadU(Tag(), lanes));
}
HWY_INLINE void from_lanes(const double* lanes, double& x) {
  x = *lanes;
}
/// The number of lanes of a type.
template <class Real>
constexpr std::size_t kLanesOf = sizeof(Real) / sizeof(double);
/// |x| with the sign of `sign`.
template <class Tag>
HWY_INLINE Number<Tag> with_sign(Number<Tag> x, Number<Tag> sign) {
  return Number<Tag>(hn::CopySign(x.v, sign.v));
}
HWY_INLINE double with_sign(double x, double sign) {
  return std::copysign(x, sign);
}
/// `inside` where |x| < limit, `outside` elsewhere.
template <class Tag>
HWY_INLINE Number<Tag> where_small(Number<Tag> x, double limit, Number<Tag> inside,
                                   Number<Tag> outside) {
  return Number<Tag>(
      hn::IfThenElse(hn::Lt(hn::Abs(x.v), Number<Tag>(limit).v), inside.v, outside.v));
}
HWY_INLINE double where_small(double x, double limit, double inside, double outside) {
  return std::abs(x) < limit ? inside : outside;
}

/// Ψ(I₁, I₂, J) of a material M and its derivatives (derivatives.h). There is one specialisation for
/// every material, in a file of its own, with the functions
///
///     energy(m, s)               Ψ, zero at rest
///     first_derivatives(m, s)    FirstDerivatives, with Zero for those that vanish identically
///     second_derivatives(m, s)   SecondDerivatives, with Zero for those that vanish identically
///
/// The type of m is M::Parameters<T>, where T is double or Real. The type of s is
/// StrainMeasures<Real> if the material is defined for any J, and Invariants<Real>
/// otherwise. A law with StrainMeasures also has spherical(m, s) = ∂Ψ/∂I₁ + (I₁ − 1) ∂Ψ/∂I₂. It is
/// written without the terms of order one, which cancel at rest and would cost digits.
///
/// The law of a material with kPrincipalStretches has the functions of principal-inl.h instead. That of a
/// material with a limit of its stretch (HasStretchLimit) also has margin(m, s), the stretch_margin().
template <class M>
struct Law;

template <class M>
using TermsOf = LawTerms<Law<M>, M>;

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
