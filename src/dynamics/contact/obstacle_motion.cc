#include <Eigen/Geometry>

#include "contact_unit.h"
#include "tetraction/dynamics/contact/obstacle.h"

namespace tetraction {
namespace {

// A(t) = ∫ a dt from 0 to the time.
double path(const ObstacleMotion& motion, double time) {
  return time > 0.0 ? time * motion.history.mean(TimeSpan{0.0, time}) : 0.0;
}

Matrix3 rotation_by(const ObstacleMotion& motion, double path) {
  const double rate = motion.angular_velocity.norm();
  if (rate == 0.0) return Matrix3::Identity();
  return Eigen::AngleAxisd(path * rate, motion.angular_velocity / rate).toRotationMatrix();
}

}  // namespace

MeshShape box_surface(const Vector3& min, const Vector3& max) {
  MeshShape box;
  for (int i = 0; i < 8; ++i) {
    box.points.emplace_back((i & 1) != 0 ? max.x() : min.x(), (i & 2) != 0 ? max.y() : min.y(),
                            (i & 4) != 0 ? max.z() : min.z());
  }
  // Two triangles of each side, outward.
  box.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return box;
}

ObstacleFrame frame_at(const ObstacleMotion& motion, double time, double load_factor) {
  ObstacleFrame frame;
  frame.shift = load_factor * motion.offset;
  if (motion.at_rest()) return frame;
  const double along = path(motion, time);
  frame.rotation = rotation_by(motion, along);
  frame.shift += along * motion.velocity + (motion.about - frame.rotation * motion.about);
  return frame;
}

Matrix3 middle_rotation(const ObstacleMotion& motion, double begin, double end) {
  if (motion.angular_velocity.isZero(0.0)) return Matrix3::Identity();
  return rotation_by(motion, 0.5 * (path(motion, begin) + path(motion, end)));
}

}  // namespace tetraction
