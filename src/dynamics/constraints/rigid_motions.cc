#include "rigid_motions.h"

#include <Eigen/Geometry>

#include "core/decompositions.h"

namespace tetraction {

Vector without_rigid_motion(const Vector& x, const Vector& d, const std::vector<bool>& acts) {
  const auto for_each = [&](const auto& body) {
    for (std::size_t v = 0; v < acts.size(); ++v) {
      if (acts[v]) body(static_cast<Index>(v));
    }
  };
  double count = 0.0;
  Vector3 center = Vector3::Zero();
  Vector3 mean = Vector3::Zero();
  for_each([&](Index v) {
    count += 1.0;
    center += vertex_block(x, v);
    mean += vertex_block(d, v);
  });
  center /= count;
  mean /= count;
  Matrix3 inertia = Matrix3::Zero();
  Vector3 moment = Vector3::Zero();
  for_each([&](Index v) {
    const Vector3 arm = vertex_block(x, v) - center;
    inertia += arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose();
    moment += arm.cross(Vector3(vertex_block(d, v) - mean));
  });
  const Vector3 rotation = rotation_of(inertia, moment);
  Vector rest = Vector::Zero(d.size());
  for_each([&](Index v) {
    vertex_block(rest, v) =
        vertex_block(d, v) - mean - rotation.cross(Vector3(vertex_block(x, v) - center));
  });
  return rest;
}

Vector3 rotation_of(const Matrix3& inertia, const Vector3& moment) {
  const SymmetricEigen3 eigen = symmetric_eigen(inertia);
  Vector3 rotation = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    if (!(eigen.values[i] > 1e-12 * eigen.values[2])) continue;
    const Vector3 axis = eigen.vectors.col(i);
    rotation += axis.dot(moment) / eigen.values[i] * axis;
  }
  return rotation;
}

bool is_in_balance(const Vector& x, const Vector& g) {
  constexpr double kRoundOff = 1e-10;
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  double force_scale = 0.0;
  double moment_scale = 0.0;
  const Vector3 origin = vertex_block(x, 0);
  for (Index v = 0; v < g.size() / 3; ++v) {
    const Vector3 each = vertex_block(g, v);
    const Vector3 arm = vertex_block(x, v) - origin;
    force += each;
    moment += arm.cross(each);
    force_scale += each.norm();
    moment_scale += arm.norm() * each.norm();
  }
  return force.norm() <= kRoundOff * force_scale && moment.norm() <= kRoundOff * moment_scale;
}

}  // namespace tetraction
