// Contact of bodies with each other and with themselves, as plain data.
#pragma once

#include <array>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// What may touch, and the layer that keeps it apart. A body is a set of tetrahedra that hang together by their
/// vertices.
struct BodyContact {
  bool within_bodies = false;  ///< whether a body may touch itself, too
  double thickness = 0.0;      ///< d̂ of the barrier (contact/barrier.h), m; above 0
  double stiffness = 0.0;      ///< κ of the barrier, Pa; above 0
  double friction = 0.0;       ///< coefficient μ of Coulomb friction; 0 or more
  double slip_speed = 1.0e-3;  ///< ε_v, m/s: friction grows up to this speed; above 0
  /// The faces of the boundary that may touch each other, by the numbers of their corners, outward.
  std::vector<std::array<Index, 3>> surface;
  bool operator==(const BodyContact&) const = default;
};

}  // namespace tetraction
