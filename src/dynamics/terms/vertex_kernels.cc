#include "vertex_kernels.h"

#include "core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dynamics/terms/vertex_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for every instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tetraction {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
constexpr size_t kLanes = hn::MaxLanes(D());

// One number for each of kLanes vertices, three times each: the factors of 3 kLanes coordinates.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void spread(D, V m, V* out) {
  for (int k = 0; k < 3; ++k) out[k] = m;
}
#else
HWY_INLINE void spread(D d, V m, V* out) {
  alignas(64) int64_t index[3 * kLanes];
  for (size_t i = 0; i < 3 * kLanes; ++i) index[i] = static_cast<int64_t>(i / 3);
  for (size_t k = 0; k < 3; ++k) {
    out[k] = hn::TableLookupLanes(m, hn::SetTableIndices(d, index + k * kLanes));
  }
}
#endif

// a_x a_y a_z a_x …: kLanes vertices' coordinates.
HWY_INLINE void repeat(D d, const Vector3& a, V* out) {
  HWY_ALIGN double values[3 * kLanes];
  for (size_t i = 0; i < 3 * kLanes; ++i) values[i] = a[static_cast<Index>(i % 3)];
  for (size_t k = 0; k < 3; ++k) out[k] = hn::Load(d, values + k * kLanes);
}

bool kick_and_drift_loop(Index begin, Index end, const VertexKick& kick, double h, const double* q,
                         const double* p, double* p_out, double* v_out, double* q_out) {
  const D d;
  V acceleration[3];
  repeat(d, kick.acceleration, acceleration);
  const V dt = hn::Set(d, kick.dt);
  const V step = hn::Set(d, h);
  V check = hn::Zero(d);  // NaN as soon as a position is not finite
  Index v = begin;
  const Index last = end - static_cast<Index>(kLanes);
  for (; v <= last; v += static_cast<Index>(kLanes)) {
    V mass[3];
    V inverse[3];
    spread(d, hn::LoadU(d, kick.mass + v), mass);
    spread(d, hn::LoadU(d, kick.inverse_mass + v), inverse);
    for (size_t k = 0; k < 3; ++k) {
      const Index i = 3 * v + static_cast<Index>(k * kLanes);
      V force = hn::MulSub(mass[k], acceleration[k], hn::LoadU(d, kick.gradient + i));
      if (kick.force != nullptr) force = hn::Add(force, hn::LoadU(d, kick.force + i));
      const V momentum = hn::MulAdd(dt, force, hn::LoadU(d, p + i));
      const V velocity = hn::Mul(momentum, inverse[k]);
      const V position = hn::MulAdd(step, velocity, hn::LoadU(d, q + i));
      hn::StoreU(momentum, d, p_out + i);
      hn::StoreU(velocity, d, v_out + i);
      hn::StoreU(position, d, q_out + i);
      check = hn::Add(check, hn::Sub(position, position));
    }
  }
  bool finite = hn::AllTrue(d, hn::Eq(check, hn::Zero(d)));
  for (; v < end; ++v) {
    for (Index i = 3 * v; i < 3 * v + 3; ++i) {
      double force = kick.mass[v] * kick.acceleration[i - 3 * v] - kick.gradient[i];
      if (kick.force != nullptr) force += kick.force[i];
      p_out[i] = p[i] + kick.dt * force;
      v_out[i] = p_out[i] * kick.inverse_mass[v];
      q_out[i] = q[i] + h * v_out[i];
      finite = finite && q_out[i] - q_out[i] == 0.0;
    }
  }
  return finite;
}

bool kick_loop(Index begin, Index end, const VertexKick& kick, double* p) {
  const D d;
  V acceleration[3];
  repeat(d, kick.acceleration, acceleration);
  const V dt = hn::Set(d, kick.dt);
  V check = hn::Zero(d);  // NaN as soon as a momentum is not finite
  Index v = begin;
  const Index last = end - static_cast<Index>(kLanes);
  for (; v <= last; v += static_cast<Index>(kLanes)) {
    V mass[3];
    spread(d, hn::LoadU(d, kick.mass + v), mass);
    for (size_t k = 0; k < 3; ++k) {
      const Index i = 3 * v + static_cast<Index>(k * kLanes);
      V force = hn::MulSub(mass[k], acceleration[k], hn::LoadU(d, kick.gradient + i));
      if (kick.force != nullptr) force = hn::Add(force, hn::LoadU(d, kick.force + i));
      const V momentum = hn::MulAdd(dt, force, hn::LoadU(d, p + i));
      hn::StoreU(momentum, d, p + i);
      check = hn::Add(check, hn::Sub(momentum, momentum));
    }
  }
  bool finite = hn::AllTrue(d, hn::Eq(check, hn::Zero(d)));
  for (; v < end; ++v) {
    for (Index i = 3 * v; i < 3 * v + 3; ++i) {
      double force = kick.mass[v] * kick.acceleration[i - 3 * v] - kick.gradient[i];
      if (kick.force != nullptr) force += kick.force[i];
      p[i] += kick.dt * force;
      finite = finite && p[i] - p[i] == 0.0;
    }
  }
  return finite;
}

VertexSums sums_loop(Index begin, Index end, const double* mass, const double* inverse_mass,
                     const double* q, const double* p) {
  const D d;
  V linear[3], angular[3], moment[3];
  for (size_t k = 0; k < 3; ++k) linear[k] = angular[k] = moment[k] = hn::Zero(d);
  V linear_scale = hn::Zero(d);
  V angular_scale = hn::Zero(d);
  V kinetic = hn::Zero(d);
  Index v = begin;
  const Index last = end - static_cast<Index>(kLanes);
  for (; v <= last; v += static_cast<Index>(kLanes)) {
    V x[3], u[3], l[3];
    hn::LoadInterleaved3(d, q + 3 * v, x[0], x[1], x[2]);
    hn::LoadInterleaved3(d, p + 3 * v, u[0], u[1], u[2]);
    const V m = hn::LoadU(d, mass + v);
    V pp = hn::Zero(d);
    V ll = hn::Zero(d);
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3;
      const int b = (k + 2) % 3;
      l[k] = hn::MulSub(x[a], u[b], hn::Mul(x[b], u[a]));
      linear[k] = hn::Add(linear[k], u[k]);
      angular[k] = hn::Add(angular[k], l[k]);
      moment[k] = hn::MulAdd(m, x[k], moment[k]);
      pp = hn::MulAdd(u[k], u[k], pp);
      ll = hn::MulAdd(l[k], l[k], ll);
    }
    kinetic = hn::MulAdd(pp, hn::LoadU(d, inverse_mass + v), kinetic);
    linear_scale = hn::Add(linear_scale, hn::Sqrt(pp));
    angular_scale = hn::Add(angular_scale, hn::Sqrt(ll));
  }
  const auto total = [&](V value) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, value)); };
  VertexSums sums;
  for (Index k = 0; k < 3; ++k) {
    sums.linear[k] = total(linear[k]);
    sums.angular[k] = total(angular[k]);
    sums.first_moment[k] = total(moment[k]);
  }
  sums.linear_scale = total(linear_scale);
  sums.angular_scale = total(angular_scale);
  sums.twice_kinetic = total(kinetic);
  for (; v < end; ++v) {
    const Vector3 x(q[3 * v], q[3 * v + 1], q[3 * v + 2]);
    const Vector3 u(p[3 * v], p[3 * v + 1], p[3 * v + 2]);
    const Vector3 l(x[1] * u[2] - x[2] * u[1], x[2] * u[0] - x[0] * u[2],
                    x[0] * u[1] - x[1] * u[0]);
    sums.linear += u;
    sums.angular += l;
    sums.first_moment += mass[v] * x;
    sums.linear_scale += u.norm();
    sums.angular_scale += l.norm();
    sums.twice_kinetic += u.squaredNorm() * inverse_mass[v];
  }
  return sums;
}

}  // namespace HWY_NAMESPACE
}  // namespace tetraction
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tetraction {

HWY_EXPORT(kick_and_drift_loop);
HWY_EXPORT(kick_loop);
HWY_EXPORT(sums_loop);

VertexSums& VertexSums::operator+=(const VertexSums& other) {
  linear += other.linear;
  angular += other.angular;
  linear_scale += other.linear_scale;
  angular_scale += other.angular_scale;
  twice_kinetic += other.twice_kinetic;
  first_moment += other.first_moment;
  return *this;
}

void VertexSums::put(double* values) const {
  for (Index k = 0; k < 3; ++k) {
    values[k] = linear[k];
    values[3 + k] = angular[k];
    values[6 + k] = first_moment[k];
  }
  values[9] = linear_scale;
  values[10] = angular_scale;
  values[11] = twice_kinetic;
}

void VertexSums::take(const double* values) {
  for (Index k = 0; k < 3; ++k) {
    linear[k] = values[k];
    angular[k] = values[3 + k];
    first_moment[k] = values[6 + k];
  }
  linear_scale = values[9];
  angular_scale = values[10];
  twice_kinetic = values[11];
}

bool kick_and_drift(Index begin, Index end, const VertexKick& kick, double h, const double* q,
                    const double* p, double* p_out, double* v_out, double* q_out) {
  return HWY_DYNAMIC_DISPATCH(kick_and_drift_loop)(begin, end, kick, h, q, p, p_out, v_out, q_out);
}

bool kick_only(Index begin, Index end, const VertexKick& kick, double* p) {
  return HWY_DYNAMIC_DISPATCH(kick_loop)(begin, end, kick, p);
}

VertexSums vertex_sums(Index begin, Index end, const double* mass, const double* inverse_mass,
                       const double* q, const double* p) {
  return HWY_DYNAMIC_DISPATCH(sums_loop)(begin, end, mass, inverse_mass, q, p);
}

}  // namespace tetraction
#endif
