// Facts about the loads of a scene, for people: what they act on, and how large they are.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A part of the boundary at rest, with the curved faces of quadratic elements.
struct SurfaceFacts {
  Index triangles = 0;
  double area = 0.0;  ///< m²
  /// The volume inside it if it is closed, m³; of the surface of a cavity, negative.
  double volume = 0.0;
  Index rim_edges = 0;      ///< none: the surface is closed
  double rim_length = 0.0;  ///< m, of straight edges
  Index rim_held = 0;       ///< edges of the rim whose ends cannot move
  Index rim_guided = 0;     ///< others whose ends are held in a direction or in several
  bool is_closed() const { return rim_edges == 0; }
};

SurfaceFacts surface_facts(const MechanicalSystem& system,
                           const std::vector<std::array<Index, 3>>& triangles);

/// Forces on the vertices of a body.
struct ForceFacts {
  Vector3 resultant = Vector3::Zero();  ///< N
  Vector3 moment = Vector3::Zero();     ///< about the origin, N m
  Index vertices = 0;                   ///< with a force
  Index held_vertices = 0;              ///< those that cannot move, or only as they are driven
  Vector3 held = Vector3::Zero();  ///< resultant of what acts along directions that are held, N
};

/// The facts of forces at positions (3 per vertex, N and m). Sums that are round-off are zero.
ForceFacts force_facts(const MechanicalSystem& system, const Vector& positions,
                       const Vector& forces);

/// One load of a scene.
struct LoadFacts {
  std::string key;  ///< "pressure.0", as --set names it
  LoadKind kind = LoadKind::kForce;
  double pressure = 0.0;                ///< Pa, of a pressure
  std::optional<SurfaceFacts> surface;  ///< if it acts on triangles
  Index tetrahedra = 0;                 ///< if it acts on tetrahedra
  double volume = 0.0;                  ///< of the tetrahedra, m³
  double mass = 0.0;                    ///< kg
  ForceFacts force;                     ///< with the factor 1
  std::string amplitude;                ///< its name; empty: none
  double factor = 1.0;                  ///< at t = 0: 0 if the load does not act then
  double from = 0.0;                    ///< s
  double until = 0.0;                   ///< s; may be infinite
};

/// The loads of the scene in the order of their kinds. `system` must have the loads and constraints of the
/// scene. `positions`: at t = 0, 3 per vertex, m.
std::vector<LoadFacts> load_facts(const Scene& scene, const MechanicalSystem& system,
                                  const Vector& positions);

/// The environment's forces on the body at the positions, with the factor 1. Empty if there is none.
std::optional<ForceFacts> environment_facts(const Scene& scene, const MechanicalSystem& system,
                                            const Vector& positions);
/// The forces of the spring of [pull] in the same way.
std::optional<ForceFacts> pull_facts(const Scene& scene, const MechanicalSystem& system,
                                     const Vector& positions);

/// A warning for a pressure or a traction on a group of tetrahedra that has faces inside the body, on which
/// it does not act. Empty for other loads, and for a part of a mesh.
std::string volume_group_warning(const ForceSettings& load, const MechanicalSystem& system);

}  // namespace tetraction
