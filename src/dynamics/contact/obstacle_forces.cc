// The forces of obstacles on a body, and the work that they do where they move.
#include <Eigen/Geometry>

#include "contact_unit.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

// ΔU − f̄·Δq, with the same f̄ as add_discrete_gradient(). f̄·Δq in the obstacle's frame is ΔU.
double Contact::driven_work(const ForcePoint& from, const ForcePoint& to) const {
  double work = 0.0;
  for (const Unit& unit : units_) {
    const ObstacleMotion& motion = unit.obstacle.motion;
    if (motion.at_rest()) continue;
    const Vector start = unit.local(from);
    const Vector end = unit.local(to);
    const Vector local = unit.mean_gradient(start, end);
    const Matrix3 rotation = middle_rotation(motion, from.time, to.time);
    Index i = 0;
    for (const Index v : unit.surface.vertices) {
      const Vector3 force = vertex_block(local, i);
      if (!force.isZero(0.0)) {
        const Vector3 seen = vertex_block(end, i) - vertex_block(start, i);
        const Vector3 moved = vertex_block(to.position, v) - vertex_block(from.position, v);
        work += force.dot(seen - rotation.transpose() * moved);
      }
      ++i;
    }
  }
  return work;
}

double Contact::work_of_motion(const std::vector<ObstacleForce>& forces, double time,
                               const TimeSpan& step, double dt) const {
  double work = 0.0;
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const ObstacleMotion& motion = units_[k].obstacle.motion;
    if (motion.at_rest()) continue;
    const double path = path_at(motion, step.end) - path_at(motion, step.begin);
    const Vector3 center = motion.about + path_at(motion, time) * motion.velocity + motion.offset;
    const Vector3 moment = forces[k].moment - center.cross(forces[k].force);
    const double rate = forces[k].force.dot(motion.velocity) + moment.dot(motion.angular_velocity);
    work += path * dt / step.length() * rate;
  }
  return work;
}

ObstacleForce Contact::Unit::resultant(const Matrix3& rotation, const Vector& local,
                                       const Vector& position) const {
  ObstacleForce sum;
  Index i = 0;
  for (const Index v : surface.vertices) {
    const Vector3 force = -(rotation * vertex_block(local, i++));
    sum.force += force;
    sum.moment += vertex_block(position, v).cross(force);
  }
  return sum;
}

std::vector<ObstacleForce> Contact::forces(const ForcePoint& at) const {
  std::vector<ObstacleForce> result;
  for (std::size_t k = 0; k < size(); ++k) {
    const Unit& unit = units_[k];
    const ObstacleFrame frame = unit.frame(at);
    if (unit.smooth == nullptr) {
      result.push_back(unit.resultant(frame.rotation, unit.gradient(unit.local(frame, at.position)),
                                      at.position));
      continue;
    }
    ObstacleForce sum;
    unit.for_each_near(frame, at.position, [&](Index i, Index v, const Vector3& x) {
      const Vector3 force = -(frame.rotation * unit.smooth->vertex_gradient(i, x));
      sum.force += force;
      sum.moment += vertex_block(at.position, v).cross(force);
    });
    result.push_back(sum);
  }
  return result;
}

std::vector<ObstacleForce> Contact::mean_forces(const ForcePoint& from,
                                                const ForcePoint& to) const {
  std::vector<ObstacleForce> result;
  const Vector middle = 0.5 * (from.position + to.position);
  for (std::size_t k = 0; k < size(); ++k) {
    const Unit& unit = units_[k];
    const Matrix3 rotation = middle_rotation(unit.obstacle.motion, from.time, to.time);
    result.push_back(
        unit.resultant(rotation, unit.mean_gradient(unit.local(from), unit.local(to)), middle));
  }
  return result;
}

}  // namespace tetraction
