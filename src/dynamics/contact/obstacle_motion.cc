#include <Eigen/Geometry>

#include "contact_unit.h"
#include "tetraction/dynamics/contact/obstacle.h"

namespace tetraction {
namespace {

Matrix3 rotation_by(const ObstacleMotion& motion, double path) {
  const double rate = motion.angular_velocity.norm();
  if (rate == 0.0) return Matrix3::Identity();
  return Eigen::AngleAxisd(path * rate, motion.angular_velocity / rate).toRotationMatrix();
}

}  // namespace

double path_at(const ObstacleMotion& motion, double time) {
  const double duration = time - motion.begin;
  return duration > 0.0 ? duration * motion.history.mean(TimeSpan{motion.begin, time}) : 0.0;
}

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
  ObstacleFrame frame = motion.start;
  if (!motion.at_rest()) {
    const double along = path_at(motion, time);
    const Matrix3 turn = rotation_by(motion, along);
    frame.rotation = turn * motion.start.rotation;
    frame.shift =
        along * motion.velocity + motion.about + turn * (motion.start.shift - motion.about);
  }
  frame.shift += load_factor * motion.offset;
  return frame;
}

Matrix3 middle_rotation(const ObstacleMotion& motion, double begin, double end) {
  if (motion.angular_velocity.isZero(0.0)) return motion.start.rotation;
  const double middle = 0.5 * (path_at(motion, begin) + path_at(motion, end));
  return rotation_by(motion, middle) * motion.start.rotation;
}

}  // namespace tetraction
