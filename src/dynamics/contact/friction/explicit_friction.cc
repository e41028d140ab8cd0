#include "explicit_friction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "dynamics/contact/contact_unit.h"
#include "dynamics/steppers/common_outcome.h"

namespace tetraction {
namespace {

// The slip with the velocities p_i/m_i.
Vector3 velocity_at(const ContactPoint& place, const MechanicalSystem& system, const Vector& p) {
  return place.slip(
      [&](Index v) { return Vector3(system.inverse_mass()[v] * vertex_block(p, v)); });
}

// How much faster a place slips with an impulse of one newton second in a direction of length 1, m/s.
double mobility_of(const ContactPoint& place, const MechanicalSystem& system,
                   const Vector3& direction) {
  double sum = 0.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(place.count); ++k) {
    sum += system.inverse_mass()[place.vertices.at(k)] * place.part(k, direction).squaredNorm();
  }
  return sum;
}

// A lower bound of the distance to which a layer is pressed that takes up an energy and a pressure more than at the
// distance d. The tangents of U_b and U_b′, both convex, are one where they change little.
double pressed_distance(const Barrier& layer, double d, double energy, double pressure) {
  constexpr double kLittle = 0.05;
  if (d < layer.thickness) {
    const double change = std::max(energy / -layer.slope(d), pressure / layer.curvature(d));
    if (change < kLittle * std::min(d, layer.thickness - d)) return d - change;
  }
  return std::min(layer.distance_at_energy(layer.value(d) + energy),
                  layer.distance_at_pressure(-layer.slope(d) + pressure));
}

}  // namespace

Contact::ImpactForecast Contact::impact_forecast(const ForcePoint& at, const Vector& v,
                                                 double impedance, double critical_step,
                                                 double step) const {
  // Half of the limit takes this many steps, and twice as many, to cross the layer.
  constexpr double kCrossing = 4.0;
  constexpr double kHorizon = 16.0;  // steps
  constexpr double kNear = 1.5;      // times the thickness, inside which all vertices are looked at
  constexpr double kFaster = 2.0;    // what is far may come to be so much faster
  constexpr double kWay = 0.5;  // times the thickness, which what rests may move until the horizon
  const double horizon = kHorizon * step;
  ImpactForecast forecast{critical_step, horizon};
  std::vector<Approach> found;
  for (const Unit& unit : units_) {
    const Vector x = unit.local(at);
    // The velocities that the obstacle sees in the next step, and on the way to the horizon.
    const auto seen = [&](double time) {
      const ForcePoint later{at.mass, at.position, at.time + time};
      const ObstacleFrame frame = unit.frame(later);
      return Vector((unit.local(frame, at.position + time * v) - x) / time);
    };
    const Vector velocity = seen(step);
    double largest = 0.0;
    for (const Vector& each : {velocity, seen(horizon)}) {
      for (Index i = 0; i < each.size() / 3; ++i) {
        largest = std::max(largest, vertex_block(each, i).squaredNorm());
      }
    }
    const double thickness = unit.obstacle.thickness;
    largest = std::max(kFaster * std::sqrt(largest), kWay * thickness / horizon);
    const double near = kNear * thickness;
    found.clear();
    unit.law->approaching(x, velocity, near + horizon * largest, found);
    for (const Approach& each : found) {
      const double way = std::max(0.0, each.distance - near);
      forecast.valid_for = std::min(forecast.valid_for, way / largest);
      const double speed = std::max(0.0, each.speed);
      const Barrier layer{each.reach * thickness, unit.obstacle.stiffness};
      const double mass = at.mass[unit.surface.vertices[static_cast<std::size_t>(each.vertex)]];
      if (each.distance >= layer.thickness + 2.0 * step * speed) continue;
      forecast.valid_for = 0.0;
      const double area = unit.surface.areas[static_cast<std::size_t>(each.vertex)];
      const double carrying = each.carrying > 0.0 ? each.carrying : each.weight;
      const double pressed =
          pressed_distance(layer, each.distance, 0.5 * mass / carrying * speed * speed,
                           impedance * speed * std::max(1.0, area / carrying));
      const double rate = each.weight * layer.curvature(pressed) / (4.0 * mass);
      forecast.limit =
          std::min(forecast.limit, 1.0 / std::sqrt(1.0 / (critical_step * critical_step) + rate));
      if (speed > 0.0) {
        forecast.limit = std::min(forecast.limit, layer.thickness / (kCrossing * speed));
      }
    }
  }
  return forecast;
}

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
      for (int i = 0; i < place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        Index& v = place.vertices.at(n);
        v = unit.surface.vertices[static_cast<std::size_t>(v)];
        point += place.weights.at(n) * vertex_block(q, v);
      }
      place.normal = frame.rotation * place.normal;
      const Vector3 seen = frame.to_local(point);
      const Vector3 drift = (end.to_world(seen) - begin.to_world(seen)) / (span.end - span.begin);
      Vector3 slip = velocity_at(place, system, momentum) - drift;
      slip -= place.normal.dot(slip) * place.normal;
      const double speed = slip.norm();
      const double most = unit.obstacle.friction * place.force * dt;
      if (!(speed > 0.0) || !(most > 0.0)) continue;
      const Vector3 direction = slip / speed;
      const double stopping = speed / mobility_of(place, system, direction);
      const Vector3 impulse = -std::min(most, stopping) * direction;
      for (int i = 0; i < place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Index v = place.vertices.at(n);
        vertex_block(momentum, v) += place.part(n, impulse);
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

void ExplicitContact::set_force(const ForcePoint& at, double dt, Vector& force,
                                StepOutcome& outcome) const {
  force.setZero(system_.dof_count());
  system_.contact()->add_gradient(at, force);
  ImpulseSums sums(outcome);
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (vertex_block(force, v).isZero(0.0)) continue;
    vertex_block(force, v) *= -1.0;
    sums.add_at(vertex_block(at.position, v), dt * vertex_block(force, v));
  }
  sums.enter(outcome);
}

bool ExplicitContact::has_friction() const {
  return system_.contact() != nullptr && system_.contact()->has_friction();
}

void ExplicitContact::rub(const Vector& q, double time, double dt, const TimeSpan& span,
                          Vector& momentum, StepOutcome& outcome) {
  if (!has_friction()) return;
  friction_.apply(system_, q, time, span, dt, momentum);
  outcome.obstacle_impulses.resize(system_.contact()->size());
  ImpulseSums sums(outcome);
  friction_.for_each_impulse([&](std::size_t k, Index v, const Vector3& impulse) {
    const Vector3 moment = vertex_block(q, v).cross(impulse);
    if (k < outcome.obstacle_impulses.size()) {
      outcome.obstacle_impulses[k].force += impulse;
      outcome.obstacle_impulses[k].moment += moment;
    }
    sums.add(impulse, moment);
  });
  sums.enter(outcome);
}

void ExplicitContact::rub_and_drift(const State& from, State& to, double dt, const TimeSpan& span,
                                    StepOutcome& outcome) {
  if (!has_friction()) return;
  rub(from.position, from.time, dt, span, to.momentum, outcome);
  for (const Index v : friction_.vertices()) {
    vertex_block(to.velocity, v) = system_.inverse_mass()[v] * vertex_block(to.momentum, v);
    vertex_block(to.position, v) =
        vertex_block(from.position, v) + span.length() * vertex_block(to.velocity, v);
  }
}

void ExplicitContact::enter_heat(const Vector& before, const Vector& after,
                                 StepOutcome& outcome) const {
  const FrictionPower energy = friction_.energy(system_, before, after);
  outcome.friction_dissipation += energy.dissipated;
  outcome.constraint_work += energy.of_obstacles;
}

void ExplicitContact::enter(const State& from, const State& to, double dt, bool twice,
                            StepOutcome& outcome) {
  const Contact* contact = system_.contact();
  if (contact == nullptr) return;
  outcome.step_size = to.time - from.time;
  const auto add = [&](const State& state) {
    const std::vector<ObstacleForce> forces =
        contact->forces(system_.force_point(state.position, state.time));
    enter_obstacle_impulses(forces, dt, outcome);
    outcome.constraint_work +=
        contact->work_of_motion(forces, state.time, {from.time, to.time}, dt);
  };
  add(from);
  if (twice) add(to);
  if (!has_friction()) return;
  enter_heat(from.momentum, to.momentum, outcome);
  if (twice) middle_momentum_ = to.momentum;
}

void ExplicitContact::finish(const State& to, bool twice, StepOutcome& outcome) const {
  if (!has_friction()) return;
  if (twice) enter_heat(middle_momentum_, to.momentum, outcome);
  outcome.friction_dissipation = std::max(0.0, outcome.friction_dissipation);
}

bool ExplicitContact::is_crossing(const State& from, const State& to, Index& vertex) const {
  const Contact* contact = system_.contact();
  if (contact == nullptr) return false;
  const auto crossing = contact->crossing(system_.force_point(from.position, from.time),
                                          system_.force_point(to.position, to.time));
  if (crossing) vertex = crossing->vertex;
  return crossing.has_value();
}

}  // namespace tetraction
