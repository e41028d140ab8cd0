// The obstacles of a scene, as plain data.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "tetraction/core/enum_names.h"
#include "tetraction/core/types.h"
#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {

/// The kinds of [[obstacle]].
enum class ObstacleKind { kPlane, kSphere, kCylinder, kBox, kMesh };
template <>
struct EnumNames<ObstacleKind> {
  static constexpr std::array names{"plane", "sphere", "cylinder", "box", "mesh"};
  static constexpr const char* noun = "a kind of obstacle";
};

/// A rigid obstacle that the body may touch (dynamics/contact/obstacle.h).
struct ObstacleSettings {
  std::string name;  ///< each name once
  ObstacleKind kind = ObstacleKind::kPlane;
  Vector3 point = Vector3::Zero();    ///< plane, cylinder: m
  Vector3 normal = Vector3::UnitY();  ///< plane: towards the free side
  Vector3 center = Vector3::Zero();   ///< sphere: m
  Vector3 axis = Vector3::UnitZ();    ///< cylinder
  double radius = 1.0;                ///< sphere, cylinder: m
  Vector3 min = Vector3::Zero();      ///< box: m
  Vector3 max = Vector3::Ones();      ///< box: m
  bool inside = false;                ///< sphere, cylinder, box: keeps the body inside
  std::string file{};                 ///< mesh: of a surface of triangles
  std::string unit = "m";             ///< mesh: of the file's coordinates, see length_units()
  /// mesh: the surface that the scene's reader has read from the file, in the file's unit.
  std::shared_ptr<const MeshShape> surface{};
  double friction = 0.0;               ///< μ
  double slip_speed = 1.0e-3;          ///< m/s
  std::optional<double> thickness{};   ///< m; default: a tenth of the mean edge of the surface
  std::optional<double> stiffness{};   ///< Pa; default: Young's modulus of the body
  Selection select = SelectAll{};      ///< the faces that may touch it
  Vector3 velocity = Vector3::Zero();  ///< m/s
  Vector3 angular_velocity = Vector3::Zero();              ///< rad/s
  std::optional<Vector3> about{};                          ///< m; default: its center or point
  std::string amplitude{};                                 ///< factor of both velocities; empty: 1
  double from = 0.0;                                       ///< s, of the motion
  double until = std::numeric_limits<double>::infinity();  ///< s
  Vector3 offset = Vector3::Zero();  ///< m; an equilibrium moves it there with the loads
  std::string where{};               ///< place in the scene, for messages
};

/// Which parts of the body's surface may touch each other.
enum class ContactBetween { kNone, kBodies, kAll };
template <>
struct EnumNames<ContactBetween> {
  static constexpr std::array names{"none", "bodies", "all"};
  static constexpr const char* noun = "a choice of what may touch";
};

/// Contact of bodies with each other and with themselves (dynamics/contact/contact.h), and what all contact has in
/// common.
struct ContactSettings {
  ContactBetween between = ContactBetween::kNone;
  std::optional<double> thickness{};  ///< m; default: see body_contact()
  std::optional<double> stiffness{};  ///< Pa; default: Young's modulus of the softest material
  double friction = 0.0;              ///< μ between bodies
  double slip_speed = 1.0e-3;         ///< m/s
  Selection select = SelectAll{};     ///< the faces that may touch each other
  /// The share of their mass that the vertices which may touch something keep; above 0, at most 1. The rest moves to
  /// vertices inside the body (dynamics/contact/moved_masses.h).
  double mass = 1.0;
};

}  // namespace tetraction
