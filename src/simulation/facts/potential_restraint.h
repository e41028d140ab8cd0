// What potentials and loads that depend on positions do to motions of the body.
#pragma once

#include <vector>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The gradients and the Hessian of potentials, and what loads that depend on positions add to both. A
/// uniform field restrains nothing.
struct Potentials {
  /// All of them, or without loads, or without those that act on many vertices at once, as on their mean.
  enum Kind { kAll, kWithoutLoads, kWithoutMeans };

  Vector gradient;
  HessianBlocks hessian;
  LoadStiffness loads;
  bool any = false;

  /// Whether one that acts on many vertices at once acts on any of these, which are sorted.
  bool couple(const std::vector<Index>& vertices) const;
};

Potentials potentials_of(const MechanicalSystem& system, const Vector& x, double time,
                         Contact::Support support, Potentials::Kind kind);

/// Σ |H v − ω × ∇U|² over the vertices of a part, which are sorted, relative to the size of its terms, for motions with the
/// velocities v (columns) and angular velocities ω. If a rigid motion does not change a potential, it only
/// turns its force: then H v = ω × ∇U. What a vertex cannot do does not count.
Matrix restraint_of(const MechanicalSystem& system, const Potentials& potentials,
                    const std::vector<Index>& vertices, double size, const Matrix& fields,
                    const Matrix& spins);

}  // namespace tetraction
