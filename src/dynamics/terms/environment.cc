#include "tetraction/dynamics/terms/environment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "load_factor.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// √(|q|² + ε²) without overflow or underflow.
double distance(const Vector3& q, double softening) {
  return std::hypot(q.stableNorm(), softening);
}

// Infinity times zero would be NaN. Therefore numbers beyond double precision become huge but
// finite, and a step that meets them fails because of its positions.
double bounded(double factor) {
  constexpr double kHuge = 1e300;
  return std::clamp(factor, -kHuge, kHuge);
}

}  // namespace

Environment Environment::uniform(const Vector3& acceleration) {
  if (!acceleration.allFinite()) {
    throw InputError("The environment's acceleration is not finite: give a finite strength.");
  }
  Environment environment;
  environment.acceleration_ = acceleration;
  return environment;
}

Environment Environment::attraction(double strength, double softening) {
  if (!std::isfinite(strength) || !std::isfinite(softening) || softening < 0.0) {
    throw InputError(
        "Attraction needs a finite strength and a finite softening length of 0 or more.");
  }
  Environment environment;
  environment.strength_ = strength;
  environment.softening_ = softening;
  return environment;
}

Environment Environment::custom(std::shared_ptr<const ForceField> field) {
  if (!field) throw InputError("A custom environment needs a force field, not a null pointer.");
  Environment environment;
  environment.field_ = std::move(field);
  return environment;
}

double Environment::value(double mass, const Vector3& q) const {
  if (field_) return field_->value(mass, q);
  double energy = -mass * acceleration_.dot(q);
  if (strength_ != 0.0) {
    const double r = distance(q, softening_);
    if (r > 0.0) energy -= strength_ / r;
  }
  return energy;
}

Vector3 Environment::gradient(double mass, const Vector3& q) const {
  if (field_) return field_->gradient(mass, q);
  Vector3 gradient = -mass * acceleration_;
  if (strength_ != 0.0) {
    const double r = distance(q, softening_);
    if (r > 0.0) gradient += bounded(strength_ / r / r) * (q / r);
  }
  return gradient;
}

Matrix3 Environment::hessian(double mass, const Vector3& q) const {
  if (field_) return field_->hessian(mass, q);
  if (strength_ == 0.0) return Matrix3::Zero();
  const double r = distance(q, softening_);
  if (!(r > 0.0)) return Matrix3::Zero();
  const Vector3 direction = q / r;
  return bounded(strength_ / r / r / r) *
         (Matrix3::Identity() - 3.0 * direction * direction.transpose());
}

Vector3 Environment::discrete_gradient(double mass, const Vector3& from, const Vector3& to) const {
  if (field_) return VertexPotential::discrete_gradient(mass, from, to);
  Vector3 gradient = -mass * acceleration_;
  if (strength_ != 0.0) {
    const double r0 = distance(from, softening_);
    const double r1 = distance(to, softening_);
    // U(r₁) − U(r₀) = k (r₁ − r₀)/(r₀r₁) and r₁² − r₀² = (from + to)·(to − from).
    if (r0 > 0.0 && r1 > 0.0) {
      gradient += bounded(strength_ / r0 / r1) * ((from + to) / (r0 + r1));
    }
  }
  return gradient;
}

double Environment::factor(const ForcePoint& at) const {
  return amplitude_ ? factor_at(*amplitude_, at) : 1.0;
}

std::optional<Vector3> Environment::uniform_acceleration() const {
  if (!is_uniform() || amplitude_) return std::nullopt;
  return acceleration_;
}

}  // namespace tetraction
