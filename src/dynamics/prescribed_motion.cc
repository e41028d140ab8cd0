#include "tetraction/dynamics/prescribed_motion.h"

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

Vector3 PrescribedMotion::position(const Vector3& start, double time) const {
  if (at_rest()) return start;
  const double tau = time - since;
  if (angular_velocity.isZero(0.0)) return start + tau * velocity;
  return center + tau * velocity + rotation(tau * angular_velocity) * (start - center);
}

Vector3 PrescribedMotion::rate(const Vector3& start, double time) const {
  if (angular_velocity.isZero(0.0)) return velocity;
  const double tau = time - since;
  return velocity + angular_velocity.cross(rotation(tau * angular_velocity) * (start - center));
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
