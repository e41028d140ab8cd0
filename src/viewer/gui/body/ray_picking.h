// Finds the vertex at a place of the picture. Pure geometry.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::viewer {

/// The first triangle that a ray meets, in front of its origin, and how far away.
struct RayHit {
  std::size_t triangle = 0;
  double distance = 0.0;  ///< in lengths of `direction`
};

/// `position`: 3 per vertex. `is_drawn` tells whether a point is drawn at all (clip plane).
std::optional<RayHit> first_hit(const std::vector<std::array<Index, 3>>& triangles,
                                const Vector& position, const Vector3& origin,
                                const Vector3& direction,
                                const std::function<bool(const Vector3&)>& is_drawn);

}  // namespace tetraction::viewer
