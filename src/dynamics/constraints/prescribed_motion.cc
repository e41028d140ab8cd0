#include "tetraction/dynamics/constraints/prescribed_motion.h"

#include <Eigen/Geometry>
#include <utility>

namespace tetraction {
namespace {

Matrix3 rotation(const Vector3& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0.0) return Matrix3::Identity();
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

}  // namespace

double PrescribedMotion::elapsed(double time) const {
  if (!velocity_amplitude) return time - since;
  return time < since ? -velocity_amplitude->integral({time, since})
                      : velocity_amplitude->integral({since, time});
}

Vector3 PrescribedMotion::position(const Vector3& start, double time) const {
  if (at_rest()) return start;
  const double tau = elapsed(time);
  Vector3 x = start + tau * velocity;
  if (!angular_velocity.isZero(0.0)) {
    x = center + tau * velocity + rotation(tau * angular_velocity) * (start - center);
  }
  if (offset_amplitude) x += offset_amplitude->value(time) * offset;
  return x;
}

Vector3 PrescribedMotion::rate(const Vector3& start, double time) const {
  Vector3 rate = velocity;
  if (!angular_velocity.isZero(0.0)) {
    rate += angular_velocity.cross(rotation(elapsed(time) * angular_velocity) * (start - center));
  }
  if (velocity_amplitude) rate *= velocity_amplitude->value(time);
  if (offset_amplitude) rate += offset_amplitude->rate(time) * offset;
  return rate;
}

PrescribedVertices prescribe_at_rest(const TetMesh& mesh, std::vector<Index> vertices,
                                     std::string name) {
  PrescribedVertices held;
  held.start.resize(3, static_cast<Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    held.start.col(static_cast<Index>(i)) = mesh.vertices[static_cast<std::size_t>(vertices[i])];
  }
  held.vertices = std::move(vertices);
  held.name = std::move(name);
  return held;
}

}  // namespace tetraction
