#include "friction_step.h"

#include "dynamics/contact/contact_unit.h"

namespace tetraction {
namespace {

// f₀ and its second derivative.
double smooth_distance(double y, double slip_speed) {
  if (y >= slip_speed) return y - slip_speed / 3.0;
  return y * y / slip_speed * (1.0 - y / (3.0 * slip_speed));
}
double smooth_rate(double y, double slip_speed) {
  return y >= slip_speed ? 0.0 : 2.0 / slip_speed * (1.0 - y / slip_speed);
}

Vector3 tangential(const Vector3& normal, const Vector3& u) {
  return u - normal.dot(u) * normal;
}

}  // namespace

void FrictionStep::begin(const Contact& contact, const Vector& start, double begin, double end,
                         NormalForces forces) {
  contact_ = &contact;
  start_ = &start;
  begin_ = begin;
  end_ = end;
  forces_ = forces;
  points_.clear();
  frames_.clear();
  for (const Contact::Unit& unit : contact.units_) {
    frames_.push_back(frame_at(unit.obstacle.motion, end));
  }
}

void FrictionStep::take(const Vector& mass, const Vector& end_position) {
  points_.clear();
  std::vector<ContactPoint> places;
  const ForcePoint from{mass, *start_, begin_};
  const ForcePoint to{mass, end_position, end_};
  for (std::size_t k = 0; k < contact_->units_.size(); ++k) {
    const Contact::Unit& unit = contact_->units_[k];
    if (!(unit.obstacle.friction > 0.0)) continue;
    places.clear();
    const Vector start = unit.local(from);
    if (forces_ == NormalForces::kMean) {
      unit.law->mean_contact_points(start, unit.local(to), places);
    } else {
      unit.law->contact_points(unit.local(to), places);
    }
    for (const ContactPoint& place : places) {
      Point point{k, place, unit.obstacle.friction * place.force, Vector3::Zero()};
      // The slip of vertices that stay where they are is the motion of the obstacle.
      for (int i = 0; i < place.count; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const Index own = place.vertices.at(n);
        const Index v = unit.surface.vertices[static_cast<std::size_t>(own)];
        point.place.vertices.at(n) = v;
        point.shift += place.weights.at(n) *
                       (frames_[k].to_local(vertex_block(*start_, v)) - vertex_block(start, own));
      }
      points_.push_back(point);
    }
  }
}

Vector3 FrictionStep::slip(const Point& point, const Vector& v) const {
  return tangential(point.place.normal, rotation(point).transpose() * velocity(point, v) +
                                            point.shift / (end_ - begin_));
}

double FrictionStep::factor(const Point& point, double speed) const {
  const double limit = contact_->obstacle(point.obstacle).slip_speed;
  return speed >= limit ? 1.0 / speed : 2.0 / limit - speed / (limit * limit);
}

double FrictionStep::potential(const Vector& v) const {
  double sum = 0.0;
  for (const Point& point : points_) {
    sum += point.limit *
           smooth_distance(slip(point, v).norm(), contact_->obstacle(point.obstacle).slip_speed);
  }
  return sum;
}

void FrictionStep::add_gradient(const Vector& v, Vector& gradient) const {
  for_each_force(v, [&](std::size_t, Index vertex, const Vector3& force) {
    vertex_block(gradient, vertex) -= force;
  });
}

void FrictionStep::add_hessian(const Vector& v, HessianBlocks& hessian) const {
  for (const Point& point : points_) {
    const Vector3 u = slip(point, v);
    const double speed = u.norm();
    const Vector3& n = point.place.normal;
    Matrix3 block = factor(point, speed) * (Matrix3::Identity() - n * n.transpose());
    if (speed > 0.0) {
      const double along = smooth_rate(speed, contact_->obstacle(point.obstacle).slip_speed);
      const Vector3 unit = u / speed;
      block += (along - factor(point, speed)) * unit * unit.transpose();
    }
    const Matrix3& turn = rotation(point);
    const Matrix3 whole = point.limit * turn * block * turn.transpose();
    for (std::size_t i = 0; i < static_cast<std::size_t>(point.place.count); ++i) {
      const Index vertex = point.place.vertices.at(i);
      hessian.add(vertex, point.place.block(i, i, whole));
      for (std::size_t j = 0; j < i; ++j) {
        hessian.add_pair(vertex, point.place.vertices.at(j), point.place.block(i, j, whole));
      }
    }
  }
}

// ∂λ/∂x_j = −stiffness w_j n.
void FrictionStep::add_force_stiffness(const Vector& v, double rate,
                                       LoadStiffness& stiffness) const {
  for (const Point& point : points_) {
    const Vector3 u = slip(point, v);
    const double mu = contact_->obstacle(point.obstacle).friction;
    const Vector3 direction = rotation(point) * (factor(point, u.norm()) * u);
    const Vector3 normal = rotation(point) * point.place.normal;
    const double scale = -rate * mu * point.place.stiffness;
    const auto count = static_cast<std::size_t>(point.place.count);
    for (std::size_t i = 0; i < count; ++i) {
      const Matrix3 block = scale * point.place.part(i, direction) * normal.transpose();
      for (std::size_t j = 0; j < count; ++j) {
        stiffness.add(point.place.vertices.at(i), point.place.vertices.at(j),
                      point.place.weights.at(j) * block);
      }
    }
  }
}

FrictionPower FrictionStep::power(const Vector& v) const {
  FrictionPower power;
  for (const Point& point : points_) {
    const Vector3 u = slip(point, v);
    const double heat = point.limit * factor(point, u.norm()) * u.squaredNorm();
    power.dissipated += heat;
    if (point.obstacle < contact_->size()) {
      power.of_obstacles += force(point, u).dot(velocity(point, v)) + heat;
    }
  }
  return power;
}

}  // namespace tetraction
