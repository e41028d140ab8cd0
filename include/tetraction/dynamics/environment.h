// The conservative force field around the body.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// A uniform field: acceleration a on every mass (zero: no environment).
/// Potential Σ −m a·q, so that gravity −g e_y has the energy Σ m g y.
class Environment {
 public:
  Environment() = default;
  /// Throws InputError if the acceleration is not finite. Unit m/s².
  explicit Environment(const Vector3& acceleration);

  const Vector3& acceleration() const { return acceleration_; }
  /// Energy of masses (one per vertex, kg) at positions q, J.
  double value(const Vector& mass, const Vector& q) const;
  /// gradient += derivative of value() (3 per vertex, N).
  void add_gradient(const Vector& mass, Vector& gradient) const;

 private:
  Vector3 acceleration_ = Vector3::Zero();
};

}  // namespace tetraction
