// The conservative force field around the body.
#pragma once

#include <memory>
#include <utility>

#include "tetraction/dynamics/terms/force_field.h"
#include "tetraction/dynamics/terms/vertex_potential.h"

namespace tetraction {

/// The environment is empty, a uniform acceleration, an attraction to the origin, or a field of the
/// user's own. Each has a potential U per vertex:
///
/// - uniform: U = −m a·q, so that gravity −g e_y has the energy m g y;
/// - attraction: U = −k/√(|q|² + ε²), force −k q/(|q|² + ε²)^{3/2}, the same k for every vertex.
///   Exactly at the origin the force is zero. Without softening (ε = 0) U has no value there and is
///   taken as zero. The second derivative of U is indefinite;
/// - custom: U of the ForceField.
///
/// An amplitude makes the strength change in time: it is the factor of U.
class Environment : public VertexPotential {
 public:
  /// No environment.
  Environment() = default;
  /// Throws InputError if the acceleration (m/s²) is not finite.
  static Environment uniform(const Vector3& acceleration);
  /// k = `strength` in N m², ε = `softening` in m. Throws InputError unless both are finite and ε ≥
  /// 0.
  static Environment attraction(double strength, double softening = 0.0);
  /// Copies share the field. Throws InputError for a null pointer.
  static Environment custom(std::shared_ptr<const ForceField> field);

  /// The same environment with a strength that changes in time. Null: it does not.
  void set_amplitude(std::shared_ptr<const Amplitude> amplitude) {
    amplitude_ = std::move(amplitude);
  }

  /// Whether the force does not depend on the position. False for every custom field.
  bool is_uniform() const { return strength_ == 0.0 && !field_; }

  /// The acceleration of a uniform environment, m/s².
  const Vector3& acceleration() const { return acceleration_; }

  /// Whether the force is known to have no bound near the origin.
  bool is_singular() const { return strength_ != 0.0 && softening_ == 0.0; }

  double value(double mass, const Vector3& q) const override;
  Vector3 gradient(double mass, const Vector3& q) const override;
  Matrix3 hessian(double mass, const Vector3& q) const override;
  /// For an attraction k (a + b)/(r₀ r₁ (r₀ + r₁)) with a, b the two ends and r = √(|q|² + ε²) there. It
  /// has no moment about the origin in a step: (a + b) × f̄ = 0.
  Vector3 discrete_gradient(double mass, const Vector3& from, const Vector3& to) const override;

  std::string name() const override { return "environment"; }
  double factor(const ForcePoint& at) const override;
  bool has_potential() const override { return !is_none(); }
  bool is_quadratic() const override { return is_uniform(); }
  std::optional<Vector3> uniform_acceleration() const override;

 private:
  bool is_none() const { return is_uniform() && acceleration_.isZero(0.0); }

  Vector3 acceleration_ = Vector3::Zero();
  double strength_ = 0.0;
  double softening_ = 0.0;
  std::shared_ptr<const ForceField> field_;
  std::shared_ptr<const Amplitude> amplitude_;
};

}  // namespace tetraction
