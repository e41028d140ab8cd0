#include "explicit_friction.h"

#include <algorithm>
#include <utility>

#include "contact_unit.h"

namespace tetraction {
namespace {

// Σ w_i p_i/m_i over the vertices of a place.
Vector3 velocity_at(const ContactPoint& place, const MechanicalSystem& system, const Vector& p) {
  Vector3 mean = Vector3::Zero();
  for (int i = 0; i < place.count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const Index v = place.vertices.at(n);
    mean += place.weights.at(n) * system.inverse_mass()[v] * vertex_block(p, v);
  }
  return mean;
}

}  // namespace

void ExplicitFriction::apply(const MechanicalSystem& system, const Vector& q, double time,
                             const TimeSpan& span, double dt, Vector& momentum) {
  impulses_.clear();
  vertices_.clear();
  const Contact& contact = *system.contact();
  const ForcePoint at = system.force_point(q, time);
  std::vector<ContactPoint> places;
  for (std::size_t k = 0; k < contact.units_.size(); ++k) {
    const Contact::Unit& unit = contact.units_[k];
    if (!(unit.obstacle.friction > 0.0)) continue;
    places.clear();
    const ObstacleFrame frame = unit.frame(at);
    const ObstacleFrame begin = frame_at(unit.obstacle.motion, span.begin);
    const ObstacleFrame end = frame_at(unit.obstacle.motion, span.end);
    unit.law->contact_points(unit.local(frame, q), places);
    for (ContactPoint& place : places) {
      Vector3 point = Vector3::Zero();
      double mobility = 0.0;
      for (int i = 0; i < place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        Index& v = place.vertices.at(n);
        v = unit.surface.vertices[static_cast<std::size_t>(v)];
        const double weight = place.weights.at(n);
        point += weight * vertex_block(q, v);
        mobility += weight * weight * system.inverse_mass()[v];
      }
      place.normal = frame.rotation * place.normal;
      const Vector3 seen = frame.to_local(point);
      const Vector3 drift = (end.to_world(seen) - begin.to_world(seen)) / (span.end - span.begin);
      Vector3 slip = velocity_at(place, system, momentum) - drift;
      slip -= place.normal.dot(slip) * place.normal;
      const double speed = slip.norm();
      const double most = unit.obstacle.friction * place.force * dt;
      if (!(speed > 0.0) || !(most > 0.0)) continue;
      const Vector3 impulse = -std::min(most, speed / mobility) / speed * slip;
      for (int i = 0; i < place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Index v = place.vertices.at(n);
        vertex_block(momentum, v) += place.weights.at(n) * impulse;
        vertices_.push_back(v);
      }
      impulses_.push_back({k, place, impulse, drift});
    }
  }
  std::sort(vertices_.begin(), vertices_.end());
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
}

FrictionPower ExplicitFriction::energy(const MechanicalSystem& system, const Vector& before,
                                       const Vector& after) const {
  FrictionPower sum;
  for (const Impulse& each : impulses_) {
    const Vector3 mean =
        0.5 * (velocity_at(each.place, system, before) + velocity_at(each.place, system, after));
    sum.dissipated -= each.impulse.dot(mean - each.drift);
    sum.of_obstacles += each.impulse.dot(each.drift);
  }
  return sum;
}

}  // namespace tetraction
