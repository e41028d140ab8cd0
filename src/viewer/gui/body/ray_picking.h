// Finds the triangle that is seen at a point of the picture.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::viewer {

/// The nearest triangle that a ray intersects in front of its origin.
struct RayHit {
  std::size_t triangle = 0;
  double distance = 0.0;  ///< from the origin, in lengths of `direction`
};

/// `position`: 3 per vertex. Intersections for which `is_drawn` returns false are ignored.
std::optional<RayHit> first_hit(const std::vector<std::array<Index, 3>>& triangles,
                                const Vector& position, const Vector3& origin,
                                const Vector3& direction,
                                const std::function<bool(const Vector3&)>& is_drawn);

}  // namespace tetraction::viewer
