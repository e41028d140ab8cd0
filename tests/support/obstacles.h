// Scenes with obstacles.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "support/runs.h"
#include "tetraction/dynamics/contact/barrier.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction::testing_support {

/// The half-space below a plane.
inline ObstacleSettings plane_obstacle(const std::string& name, const Vector3& point,
                                       const Vector3& normal = {0.0, 1.0, 0.0}) {
  ObstacleSettings plane;
  plane.name = name;
  plane.point = point;
  plane.normal = normal;
  return plane;
}

/// A ball, or what is outside it.
inline ObstacleSettings sphere_obstacle(const std::string& name, const Vector3& center,
                                        double radius, bool inside = false) {
  ObstacleSettings sphere;
  sphere.name = name;
  sphere.kind = ObstacleKind::kSphere;
  sphere.center = center;
  sphere.radius = radius;
  sphere.inside = inside;
  return sphere;
}

inline ObstacleSettings cylinder_obstacle(const std::string& name, const Vector3& point,
                                          const Vector3& axis, double radius, bool inside = false) {
  ObstacleSettings cylinder = sphere_obstacle(name, Vector3::Zero(), radius, inside);
  cylinder.kind = ObstacleKind::kCylinder;
  cylinder.point = point;
  cylinder.axis = axis;
  return cylinder;
}

/// Six walls around the body.
inline ObstacleSettings room_obstacle(const std::string& name, const Vector3& min,
                                      const Vector3& max) {
  ObstacleSettings room;
  room.name = name;
  room.kind = ObstacleKind::kBox;
  room.min = min;
  room.max = max;
  room.inside = true;
  return room;
}

/// The distance at which a layer has a pressure, m.
inline double distance_under(const Barrier& layer, double pressure) {
  double low = 0.0;
  double high = layer.thickness;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (-layer.slope(middle) > pressure ? low : high) = middle;
  }
  return high;
}

/// The smallest distance to an obstacle now, m; infinite beyond the layers.
inline double present_gap(const Session& session) {
  const MechanicalSystem& system = session.system();
  return system.contact()->smallest_gap(
      system.force_point(session.present_state().position, session.time()));
}

/// Makes all steps of a run, and expects that none ends in an obstacle. Returns the smallest distance.
inline double run_beside_obstacles(Session& session) {
  double least = present_gap(session);
  while (session.step()) {
    const double gap = present_gap(session);
    EXPECT_GT(gap, 0.0) << "step " << session.step_number();
    least = std::min(least, gap);
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  return least;
}

}  // namespace tetraction::testing_support
