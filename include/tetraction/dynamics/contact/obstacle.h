// A rigid obstacle that a body may touch, as plain data.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/dynamics/terms/amplitude.h"

namespace tetraction {

/// The half-space beyond a plane: the body stays where (x − point)·normal > 0.
struct PlaneShape {
  Vector3 point = Vector3::Zero();    ///< m
  Vector3 normal = Vector3::UnitY();  ///< towards the free side; of any length but zero
  bool operator==(const PlaneShape&) const = default;
};
/// A ball, or with `inside` all that is outside a ball.
struct SphereShape {
  Vector3 center = Vector3::Zero();  ///< m
  double radius = 0.0;               ///< m
  bool inside = false;               ///< the body stays inside
  bool operator==(const SphereShape&) const = default;
};
/// A cylinder without ends, or with `inside` all that is outside it.
struct CylinderShape {
  Vector3 point = Vector3::Zero();  ///< on the axis, m
  Vector3 axis = Vector3::UnitZ();  ///< of any length but zero
  double radius = 0.0;              ///< m
  bool inside = false;
  bool operator==(const CylinderShape&) const = default;
};
/// All that is outside a box: six walls that keep the body inside.
struct RoomShape {
  Vector3 min = Vector3::Zero();  ///< m
  Vector3 max = Vector3::Ones();  ///< m
  bool operator==(const RoomShape&) const = default;
};

/// A rigid surface of triangles, watertight or open. Both of its sides act: a watertight one is a solid for bodies
/// outside and a container for bodies inside.
struct MeshShape {
  std::vector<Vector3> points;                  ///< m; equal ones count as one
  std::vector<std::array<Index, 3>> triangles;  ///< numbers of points, from 0
  bool operator==(const MeshShape&) const = default;
};
/// The surface of a box.
MeshShape box_surface(const Vector3& min, const Vector3& max);

using ObstacleShape = std::variant<PlaneShape, SphereShape, CylinderShape, RoomShape, MeshShape>;

/// The place of an obstacle at an instant: its point X is at x = R X + shift.
struct ObstacleFrame {
  Matrix3 rotation = Matrix3::Identity();  ///< R
  Vector3 shift = Vector3::Zero();         ///< m

  Vector3 to_local(const Vector3& x) const { return rotation.transpose() * (x - shift); }
  Vector3 to_world(const Vector3& x) const { return rotation * x + shift; }
};

/// The motion of a rigid obstacle. With its place X₀ at the time t₀ when the motion begins, the factor a(t) of
/// its history, and A(t) = ∫ a dt from t₀ to t, it is at
///
///     x(t) = c + A v + R(A ω) (X₀ − c) + offset
///
/// where R is the rotation about ω by the angle A |ω|.
struct ObstacleMotion {
  Vector3 velocity = Vector3::Zero();          ///< v, m/s
  Vector3 angular_velocity = Vector3::Zero();  ///< ω, rad/s
  Vector3 about = Vector3::Zero();             ///< c, m
  LoadHistory history;                         ///< a(t)
  double begin = 0.0;                          ///< t₀, s
  ObstacleFrame start;                         ///< X₀, without the offset
  Vector3 offset = Vector3::Zero();  ///< m; an equilibrium multiplies it by its load factor

  bool at_rest() const { return velocity.isZero(0.0) && angular_velocity.isZero(0.0); }
};

/// A(t), s.
double path_at(const ObstacleMotion& motion, double time);
/// The place at a time, s; that at its begin before that.
ObstacleFrame frame_at(const ObstacleMotion& motion, double time, double load_factor = 1.0);

/// An obstacle and the law of contact with it.
struct Obstacle {
  std::string name;
  ObstacleShape shape;
  ObstacleMotion motion;
  double thickness = 0.0;      ///< d̂ of the barrier (contact/barrier.h), m; above 0
  double stiffness = 0.0;      ///< κ of the barrier, Pa; above 0
  double friction = 0.0;       ///< coefficient μ of Coulomb friction; 0 or more
  double slip_speed = 1.0e-3;  ///< ε_v, m/s: friction grows up to this speed; above 0
  /// The faces of the body's boundary that touch the obstacle, by the numbers of their corners, outward.
  std::vector<std::array<Index, 3>> surface;
  /// Whether it was taken away. It keeps its number, and touches nothing.
  bool removed = false;
};

/// What an obstacle does to a body in a step, or at an instant.
struct ObstacleForce {
  Vector3 force = Vector3::Zero();   ///< on the body, N
  Vector3 moment = Vector3::Zero();  ///< the same about the origin, N m
};

}  // namespace tetraction
