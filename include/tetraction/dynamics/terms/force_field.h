// A conservative force field of the user's own.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// A potential U(m, q) of one vertex with the lumped mass m (kg) at the position q (m). U must not
/// depend on the time. The gradient and the Hessian must be the exact derivatives of the value,
/// because energies and the implicit rules rely on it. The three functions are called from several
/// threads at the same time. A constant in U does not change the motion, but a large one costs the
/// energies digits.
///
/// For a field per unit volume or mass make U proportional to m, because the lumped mass of a
/// vertex is ρ times its share of the volume. See Environment::custom().
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
