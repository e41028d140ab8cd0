// The geometry of a step of the elements, for the kernels of discrete gradients. Highway includes this file once for
// each instruction set.
#if defined(TETRACTION_FEM_DISCRETE_GEOMETRY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TETRACTION_FEM_DISCRETE_GEOMETRY_INL_H_
#undef TETRACTION_FEM_DISCRETE_GEOMETRY_INL_H_
#else
#define TETRACTION_FEM_DISCRETE_GEOMETRY_INL_H_
#endif

#include "discrete_gradient_kernels.h"
// These have names of their own for what has the names Vec and Real below: they come first.
#include "element_parameters-inl.h"
#include "material/laws/laws-inl.h"
#include "principal-inl.h"
#include "simd_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {

using Tag = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Tag>;
using Real = Number<Tag>;

HWY_INLINE Real quotient(Real a, Real b) {
  return Real(hn::Div(a.v, b.v));
}

// A derivative of a law as a number.
HWY_INLINE Real number(Real a) {
  return a;
}
HWY_INLINE Real number(Zero) {
  return Real(0.0);
}

HWY_INLINE Real trace(const Columns<Vec>& m) {
  return Real(hn::Add(m.m[0][0], hn::Add(m.m[1][1], m.m[2][2])));
}
// a:b of symmetric matrices.
HWY_INLINE Real contract(const Symmetric<Vec>& a, const Symmetric<Vec>& b) {
  const Vec on = hn::MulAdd(a.m[0], b.m[0], hn::MulAdd(a.m[3], b.m[3], hn::Mul(a.m[5], b.m[5])));
  const Vec off = hn::MulAdd(a.m[1], b.m[1], hn::MulAdd(a.m[2], b.m[2], hn::Mul(a.m[4], b.m[4])));
  return Real(hn::Add(on, hn::Add(off, off)));
}
// The cofactors of a symmetric matrix. Returns its determinant.
HWY_INLINE Real cofactors_of(const Symmetric<Vec>& a, Symmetric<Vec>& w) {
  w(0, 0) = hn::MulSub(a(1, 1), a(2, 2), hn::Mul(a(1, 2), a(1, 2)));
  w(0, 1) = hn::MulSub(a(0, 2), a(1, 2), hn::Mul(a(0, 1), a(2, 2)));
  w(0, 2) = hn::MulSub(a(0, 1), a(1, 2), hn::Mul(a(0, 2), a(1, 1)));
  w(1, 1) = hn::MulSub(a(0, 0), a(2, 2), hn::Mul(a(0, 2), a(0, 2)));
  w(1, 2) = hn::MulSub(a(0, 1), a(0, 2), hn::Mul(a(0, 0), a(1, 2)));
  w(2, 2) = hn::MulSub(a(0, 0), a(1, 1), hn::Mul(a(0, 1), a(0, 1)));
  return Real(
      hn::MulAdd(a(0, 0), w(0, 0), hn::MulAdd(a(0, 1), w(0, 1), hn::Mul(a(0, 2), w(0, 2)))));
}
// sum += factor a.
HWY_INLINE void add_scaled(Real factor, const Symmetric<Vec>& a, Symmetric<Vec>& sum) {
  for (int k = 0; k < 6; ++k) sum.m[k] = hn::MulAdd(factor.v, a.m[k], sum.m[k]);
}
HWY_INLINE void scale(Real factor, Symmetric<Vec>& a) {
  for (Vec& v : a.m) v = hn::Mul(factor.v, v);
}

// The geometry of a step of the elements in the lanes.
struct Geometry {
  Columns<Vec> e;      // mean edges
  Columns<Vec> d;      // half of their change
  Symmetric<Vec> g;    // G
  Real volume = 0.0;   // V
  Symmetric<Vec> c;    // c̄
  Symmetric<Vec> dc;   // δ
  Columns<Vec> cg;     // c̄ G
  Columns<Vec> dcg;    // δ G
  Symmetric<Vec> gdg;  // G δ G
  Real inverse_six_volume = 0.0;
  Real square = 0.0;  // δ:GδG

  HWY_INLINE Geometry(const StepRecords& step, const double* HWY_RESTRICT rest,
                      const uint16_t* HWY_RESTRICT slots) {
    const Tag tag;
    RecordAccess<Tag>::edges<true>(tag, step.positions, step.displacements, slots, kBatchLanes, e);
    RecordAccess<Tag>::edges(tag, step.half_steps, slots, kBatchLanes, d);
    inverse_six_volume = Real(hn::Load(tag, rest + 6 * kBatchLanes));
    const Real inverse_volume = Real(6.0) * inverse_six_volume;
    volume = quotient(Real(1.0), inverse_volume);
    for (size_t k = 0; k < 6; ++k) {
      g.m[k] = hn::Mul(hn::Load(tag, rest + k * kBatchLanes), inverse_volume.v);
    }
    Symmetric<Vec> dd;
    metric(e, c);
    metric(d, dd);
    for (int k = 0; k < 6; ++k) c.m[k] = hn::Add(c.m[k], dd.m[k]);
    symmetric_sum(e, d, dc);
    symmetric_times(c, g, cg);
    symmetric_times(dc, g, dcg);
    symmetric_product(g, dcg, gdg);
    square = contract(dc, gdg);
  }

  HWY_INLINE Columns<Vec> end() const {
    Columns<Vec> sum;
    for (int k = 0; k < 9; ++k) {
      sum.m[k / 3][k % 3] = hn::Add(e.m[k / 3][k % 3], d.m[k / 3][k % 3]);
    }
    return sum;
  }
  // Whether J is positive and finite at the end of the step in all lanes.
  HWY_INLINE bool ends_admissible() const {
    const Tag tag;
    Columns<Vec> w;
    const Vec det = cofactors(end(), w);
    return hn::AllTrue(tag, hn::And(hn::Gt(det, hn::Zero(tag)), hn::Lt(det, hn::Set(tag, 1e300))));
  }
  // The forces of a stress s̄ and, with a direction, of its change.
  HWY_INLINE void scatter(const Columns<Vec>& edges, const Symmetric<Vec>& stress,
                          const uint16_t* HWY_RESTRICT slots, double* HWY_RESTRICT records) const {
    Columns<Vec> forces;
    multiply(edges, stress, forces);
    RecordAccess<Tag>::add_balanced(Tag(), forces, records, slots, kBatchLanes);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#endif
