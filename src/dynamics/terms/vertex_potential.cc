#include "tetraction/dynamics/terms/vertex_potential.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "tetraction/core/parallel.h"

namespace tetraction {
Index VertexPotential::undefined_vertex(const ForcePoint& at) const {
  std::atomic<Index> first{at.mass.size()};
  parallel_for(at.mass.size(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      if (defined(vertex_block(at.position, v))) continue;
      Index known = first;
      while (v < known && !first.compare_exchange_weak(known, v)) {
      }
      return;
    }
  });
  return first == at.mass.size() ? -1 : first.load();
}

double VertexPotential::longest_step(const ForcePoint& from, const Vector& displacement) const {
  double longest = std::numeric_limits<double>::infinity();
  std::mutex mutex;
  parallel_for(from.mass.size(), kVertexGrain, [&](Index begin, Index end) {
    double own = std::numeric_limits<double>::infinity();
    for (Index v = begin; v < end; ++v) {
      own = std::min(
          own, admissible_fraction(vertex_block(from.position, v), vertex_block(displacement, v)));
    }
    const std::lock_guard<std::mutex> lock(mutex);
    longest = std::min(longest, own);
  });
  return longest;
}

double VertexPotential::energy(const ForcePoint& at) const {
  return factor(at) * parallel_sum(at.mass.size(), [&](Index begin, Index end) {
           double sum = 0.0;
           for (Index v = begin; v < end; ++v)
             sum += value(at.mass[v], vertex_block(at.position, v));
           return sum;
         });
}

double VertexPotential::energy_change(const ForcePoint& from, const ForcePoint& to) const {
  const double before = factor(from);
  const double after = factor(to);
  return parallel_sum(from.mass.size(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      sum += after * value(to.mass[v], vertex_block(to.position, v)) -
             before * value(from.mass[v], vertex_block(from.position, v));
    }
    return sum;
  });
}

void VertexPotential::add_gradient(const ForcePoint& at, Vector& gradient) const {
  const double factor = this->factor(at);
  parallel_for(at.mass.size(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(gradient, v) +=
          factor * this->gradient(at.mass[v], vertex_block(at.position, v));
    }
  });
}

void VertexPotential::add_hessian(const ForcePoint& at, HessianForm form,
                                  HessianBlocks& hessian) const {
  const double factor = this->factor(at);
  parallel_for(at.mass.size(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      const Matrix3 block = factor * this->hessian(at.mass[v], vertex_block(at.position, v));
      hessian.add(v, form == HessianForm::kExact ? block : positive_semidefinite_part(block));
    }
  });
}

Vector3 VertexPotential::discrete_gradient(double mass, const Vector3& from,
                                           const Vector3& to) const {
  const Vector3 displacement = to - from;
  Vector3 middle = gradient(mass, 0.5 * (from + to));
  const double before = value(mass, from);
  const double after = value(mass, to);
  const double linear = middle.dot(displacement);
  const double rest = after - before - linear;
  // A difference that may be round-off, divided by a small distance, would give a force that is far too large.
  const double round_off = 64.0 * std::numeric_limits<double>::epsilon() *
                           (std::abs(before) + std::abs(after) + std::abs(linear));
  if (!(std::abs(rest) > round_off)) return middle;
  return middle + rest / displacement.squaredNorm() * displacement;
}

void VertexPotential::add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                                            Vector& gradient) const {
  const double mean = factor({to.mass, to.position, to.time, TimeSpan{from.time, to.time}});
  parallel_for(from.mass.size(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(gradient, v) +=
          mean * discrete_gradient(from.mass[v], vertex_block(from.position, v),
                                   vertex_block(to.position, v));
    }
  });
}

double VertexPotential::driven_work(const ForcePoint& from, const ForcePoint& to) const {
  const double before = factor(from);
  const double after = factor(to);
  const double mean = factor({to.mass, to.position, to.time, TimeSpan{from.time, to.time}});
  if (before == mean && after == mean) return 0.0;
  // The force with the mean factor does the work mean (U(from) − U(to)). What is not a decrease of
  // the potential energy is driven work.
  double work = 0.0;
  for (Index v = 0; v < from.mass.size(); ++v) {
    work += (after - mean) * value(to.mass[v], vertex_block(to.position, v)) -
            (before - mean) * value(from.mass[v], vertex_block(from.position, v));
  }
  return work;
}

}  // namespace tetraction
