// A conservative force field of the user's own.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// A potential U(m, q) of one vertex of lumped mass m (kg) at position q (m) that does not change
/// with time. The three functions have to belong together: energies and the implicit rules rely on
/// it. They are called from several threads at once. A constant in U moves no body, but a large one
/// costs the energies digits.
///
/// For a field per unit volume or mass make U proportional to m; the lumped mass of a vertex is ρ
/// times its share of the volume. See Environment::custom().
class ForceField {
 public:
  virtual ~ForceField() = default;
  /// U, J.
  virtual double value(double mass, const Vector3& q) const = 0;
  /// ∂U/∂q, N: minus the force.
  virtual Vector3 gradient(double mass, const Vector3& q) const = 0;
  /// ∂²U/∂q², symmetric, N/m. May be indefinite.
  virtual Matrix3 hessian(double mass, const Vector3& q) const = 0;

 protected:
  ForceField() = default;
  ForceField(const ForceField&) = default;
  ForceField& operator=(const ForceField&) = default;
};

}  // namespace tetraction
