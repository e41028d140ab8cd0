// The equations of constraints as a part of the function that is minimised.
#pragma once

#include "tetraction/dynamics/constraints/constraints.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// The part that distances and rigid handles have in an augmented Lagrangian (Nocedal & Wright 2006, section
/// 17.3), J:
///
///     A(x) = Σ_i (½ k_i g_i(w)² − λ_i g_i(w)),     w = Bᵀx
///
/// with multipliers λ and stiffnesses k, both J. Where g = 0, its gradient is that of −λ·g alone: the stiffnesses
/// change no solution. Its Hessian has the curvature −Σ λ_i ∂²g_i, without which a constraint force would be a
/// dead load. With k large enough, the Hessian of the whole function is positive definite at a minimum on the
/// constraints, although without A it may be indefinite there.
class ConstraintPotential {
 public:
  /// Keeps a reference to `constraints`, which must live longer.
  explicit ConstraintPotential(const Constraints& constraints) : constraints_(constraints) {}

  /// k ← the stiffness of the body at rest against a motion of the constrained vertices alone that violates one
  /// equation: aᵀKa/(aᵀa)² with the gradient a of the equation over the free coordinates. It is at least that
  /// against the same violation when the other vertices follow. `coefficient` is a diagonal part of K, N/m, 3
  /// per vertex, beside the elastic one.
  void set_stiffness(const ElasticPotential& elastic, const Vector& rest_positions,
                     const Vector& coefficient);
  bool has_stiffness() const { return stiffness_.size() == constraints_.equation_count(); }
  void multiply_stiffness(double factor) { stiffness_ *= factor; }
  const Vector& stiffness() const { return stiffness_; }
  /// Sets a stiffness() of earlier, which may be empty.
  void restore_stiffness(const Vector& stiffness) { stiffness_ = stiffness; }
  void set_multipliers(const Vector& multipliers) { multipliers_ = multipliers; }
  const Vector& multipliers() const { return multipliers_; }
  /// The displacements of values() and the other functions begin here, m.
  void set_origin(const Vector& origin) { origin_ = constraints_.configuration(origin); }

  /// w, m, and g(w) at the displacement u.
  Vector configuration(const Vector& u) const { return origin_ + constraints_.configuration(u); }
  Vector values(const Vector& u) const { return constraints_.values(configuration(u)); }
  /// λ − k g: the multipliers whose forces are minus the gradient of A at u.
  Vector total_multipliers(const Vector& u) const;
  double value(const Vector& u) const;
  void add_gradient(const Vector& u, Vector& gradient) const;
  void add_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const;

 private:
  const Constraints& constraints_;
  Vector stiffness_;
  Vector multipliers_;
  Vector origin_;
};

}  // namespace tetraction
