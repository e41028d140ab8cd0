// Directions of negative curvature of Φ.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// A direction d that the constraints allow (3 per vertex), with dᵀ∇²Φ d < 0.
struct NegativeCurvature {
  Vector direction;
  double curvature = 0.0;  ///< dᵀ∇²Φ d

  bool found() const { return direction.size() > 0; }
};

}  // namespace tetraction
