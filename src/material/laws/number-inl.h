// Arithmetic in which laws are written, for a double and for a vector of numbers. Included by
// Highway once per instruction set.
#if defined(TETRACTION_MATERIAL_NUMBER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_MATERIAL_NUMBER_INL_H_
#undef TETRACTION_MATERIAL_NUMBER_INL_H_
#else
#define TETRACTION_MATERIAL_NUMBER_INL_H_
#endif

#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <cmath>

#include "derivatives.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One number in each lane, with the usual operators; constants go to all lanes.
template <class D>
struct Number {
  hn::Vec<D> v;

  HWY_INLINE Number() : v(hn::Undefined(D())) {}
  HWY_INLINE Number(double constant)  // NOLINT(google-explicit-constructor)
      : v(hn::Set(D(), static_cast<hn::TFromD<D>>(constant))) {}
  HWY_INLINE explicit Number(hn::Vec<D> vector) : v(vector) {}

  friend HWY_INLINE Number operator+(Number a, Number b) { return Number(hn::Add(a.v, b.v)); }
  friend HWY_INLINE Number operator-(Number a, Number b) { return Number(hn::Sub(a.v, b.v)); }
  friend HWY_INLINE Number operator*(Number a, Number b) { return Number(hn::Mul(a.v, b.v)); }
  friend HWY_INLINE Number operator-(Number a) { return Number(hn::Neg(a.v)); }
};

/// a b + c, rounded once where the processor can.
template <class D>
HWY_INLINE Number<D> mul_add(Number<D> a, Number<D> b, Number<D> c) {
  return Number<D>(hn::MulAdd(a.v, b.v, c.v));
}
HWY_INLINE double mul_add(double a, double b, double c) {
  return a * b + c;
}
/// a b − c.
template <class D>
HWY_INLINE Number<D> mul_sub(Number<D> a, Number<D> b, Number<D> c) {
  return Number<D>(hn::MulSub(a.v, b.v, c.v));
}
HWY_INLINE double mul_sub(double a, double b, double c) {
  return a * b - c;
}
/// eˣ.
template <class D>
HWY_INLINE Number<D> exponential(Number<D> x) {
  return Number<D>(hn::Exp(D(), x.v));
}
HWY_INLINE double exponential(double x) {
  return std::exp(x);
}
/// `inside` where |x| < limit, `outside` elsewhere.
template <class D>
HWY_INLINE Number<D> where_small(Number<D> x, double limit, Number<D> inside, Number<D> outside) {
  return Number<D>(hn::IfThenElse(hn::Lt(hn::Abs(x.v), Number<D>(limit).v), inside.v, outside.v));
}
HWY_INLINE double where_small(double x, double limit, double inside, double outside) {
  return std::abs(x) < limit ? inside : outside;
}

/// Ψ(I₁, I₂, J) of a material M and its derivatives (derivatives.h); there is one specialisation
/// for every material, in a file of its own:
///
///     energy(m, s)   Ψ, 0 at rest
///     first(m, s)    FirstDerivatives, Zero where one vanishes identically
///     second(m, s)   SecondDerivatives, likewise
///
/// with s of the type Invariants<N>, or StrainMeasures<N> of a material that is defined for any J.
/// Such a law has also spherical(m, s) = ∂Ψ/∂I₁ + (I₁ − 1) ∂Ψ/∂I₂, where terms of order one cancel
/// at rest.
template <class M>
struct Law;

template <class M>
using TermsOf = LawTerms<Law<M>, M>;

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
