// The surfaces of triangles that the obstacles of a scene have from files.
#pragma once

#include <variant>

#include "core/fingerprint.h"
#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Calls function(obstacle) for the obstacles of the scene and those that its events add or change.
template <class Function>
void for_each_obstacle(const Scene& scene, const Function& function) {
  for (const ObstacleSettings& obstacle : scene.obstacle) function(obstacle);
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      if (const auto* change = std::get_if<SetObstacle>(&edit)) function(change->entry);
    }
  }
}

/// Adds the points and triangles of all surfaces to a fingerprint. A scene without them adds nothing.
inline void add_surfaces(const Scene& scene, Fingerprint& fingerprint) {
  for_each_obstacle(scene, [&](const ObstacleSettings& obstacle) {
    if (obstacle.kind != ObstacleKind::kMesh || obstacle.surface == nullptr) return;
    for (const Vector3& point : obstacle.surface->points) {
      for (const double coordinate : point) fingerprint.add(coordinate);
    }
    for (const auto& triangle : obstacle.surface->triangles) {
      for (const Index corner : triangle) fingerprint.add(static_cast<std::uint64_t>(corner));
    }
  });
}

}  // namespace tetraction
