// Facts about the supports of a scene, for people: what is held, and how.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetraction/core/enum_names.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/run_settings.h"

namespace tetraction {

enum class SupportKind { kFix, kSprings, kPlane, kLine, kDistance, kFreeHandle, kDrivenHandle };
template <>
struct EnumNames<SupportKind> {
  static constexpr std::array names{
      "fix", "springs", "plane", "line", "distance", "free rigid handle", "driven rigid handle"};
};

/// One [[fix]] or [[constraint]] of a scene.
struct SupportFacts {
  std::string key;  ///< "fix.0", as --set names it
  SupportKind kind = SupportKind::kFix;
  Index vertices = 0;
  Index triangles = 0;  ///< of the boundary, with all corners among these vertices
  double area = 0.0;    ///< of the triangles, m²
  std::array<bool, 3> components{true, true, true};  ///< of a fix and of springs
  double stiffness = 0.0;               ///< of springs: 2γ of each component of a vertex, N/m
  Vector3 direction = Vector3::Zero();  ///< unit normal of planes, direction of lines
  std::array<std::int64_t, 2> ends{};   ///< of a distance: numbers of the mesh file
  double length = 0.0;                  ///< of a distance, m
  double mass = 0.0;                    ///< of a handle: lumped, kg
  double displacement = 0.0;  ///< largest distance from the place at rest to the target at t = 0, m
  bool moves = false;         ///< whether the targets change in time
  Vector3 velocity = Vector3::Zero();          ///< m/s, with the factor 1
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s, with the factor 1
  Vector3 center = Vector3::Zero();            ///< about which a driven handle turns, m
  std::string amplitude;                       ///< its name; empty: none
};

/// The supports in the order of the scene, [[fix]] first. `system` must have these constraints.
std::vector<SupportFacts> support_facts(const BodyConstraints& constraints,
                                        const MechanicalSystem& system);

}  // namespace tetraction
