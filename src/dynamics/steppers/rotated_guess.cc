#include "rotated_guess.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/decompositions.h"
#include "dynamics/constraints/rigid_motions.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {

Vector3 spin_of(const MechanicalSystem& system, const State& state) {
  const Vector3 center = center_of_mass(system, state.position);
  Matrix3 inertia = Matrix3::Zero();
  Vector3 momentum = Vector3::Zero();
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(state.position, v) - center;
    inertia += system.mass()[v] * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
    momentum += arm.cross(Vector3(vertex_block(state.momentum, v)));
  }
  return rotation_of(inertia, momentum);
}

void guess_rotated(const MechanicalSystem& system, const State& from, double h, const Vector3& move,
                   GuessedStrain strain, Vector& x) {
  const Vector3 center = center_of_mass(system, from.position);
  const Vector3 omega = spin_of(system, from);
  const double speed = omega.norm();
  Matrix3 turn = Matrix3::Identity();
  if (speed > 0.0) {
    turn = Eigen::AngleAxisd(std::asin(std::min(1.0, h * speed)), omega / speed).toRotationMatrix();
  }
  const Vector rest = system.mesh().rest_positions();
  const Vector3 rest_center = center_of_mass(system, rest);
  Matrix3 nearest = Matrix3::Identity();  // the rotation of the rest shape into the present one
  if (strain == GuessedStrain::kMirrored) {
    Matrix3 moment = Matrix3::Zero();
    for (Index v = 0; v < system.vertex_count(); ++v) {
      moment += system.mass()[v] * (vertex_block(from.position, v) - center) *
                (vertex_block(rest, v) - rest_center).transpose();
    }
    nearest = proper_rotation(moment);
  }
  x.resize(from.position.size());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(from.position, v) - center;
    Vector3 end = arm;
    if (strain == GuessedStrain::kMirrored) {
      end = 2.0 * (nearest * (vertex_block(rest, v) - rest_center)) - arm;
    }
    vertex_block(x, v) = vertex_block(from.position, v) + 0.5 * (move + Vector3(turn * end) - arm);
  }
}

}  // namespace tetraction
