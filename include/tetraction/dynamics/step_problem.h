// The implicit Hamilton–Pontryagin step as a minimisation.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The incremental potential of one implicit step, written in the point x = q_k + s v where the
/// force is evaluated, with s = αh (α = ½: midpoint, α = 1: backward Euler):
///
///     Φ(x) = 1/(2s²) |x − x̂|²_M + W_elastic(x),    x̂ = q_k + s M⁻¹(p_k + s f) + s² a
///
/// (Kharevych et al. 2006, the Pontryagin–d'Alembert functional). f are the user forces; the
/// uniform environment's energy −Σ m a·x is folded into x̂, which changes Φ by a constant only.
/// The minimiser over the free DOFs gives v = (x − q_k)/s. Fixed DOFs stay at q_k.
class StepProblem {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `system`, which must live longer.
  explicit StepProblem(const MechanicalSystem& system);

  /// Sets up the step of size h from `state` under the user forces f (3 per vertex, N).
  void begin(const State& state, double h, double alpha, const Vector& user_force);

  const MechanicalSystem& system() const { return system_; }
  /// s = αh, s.
  double step() const { return step_; }
  /// q_k.
  const Vector& previous_position() const { return previous_; }
  /// x̂: where the vertices would be without elastic forces; fixed DOFs at q_k.
  const Vector& inertial_target() const { return target_; }

  /// phi = Φ(x), J.
  Evaluation value(const Vector& x, double& phi) const;
  /// gradient = ∇Φ(x) (3 per vertex, N), zero at fixed DOFs.
  Evaluation value_and_gradient(const Vector& x, double& phi, Vector& gradient) const;
  /// values = ∇²Φ(x) over the free DOFs in the pattern's order, N/m.
  Evaluation hessian(const Vector& x, const SparsityPattern& pattern, double* values) const;
  /// The share of element e in Φ: its elastic energy and, as lumped mass is a sum over elements,
  /// its own part of the inertia, ½ Σ_a ρ₀V/(4s²) |x_a − x̂_a|². The shares add up to Φ.
  bool element_terms(Index e, const Vector& x, bool with_hessian,
                     ElasticPotential::ElementTerms& terms) const;

  /// Largest |∇Φ|₂ that counts as converged, N: max(tolerance × force scale, round-off).
  /// The force scale of a step is |M(x̂ − q_k)/s²|₂ over the free DOFs: the force that would give
  /// the body its momentum and the impulse of the loads within s. Round-off is what double
  /// precision leaves of positions: 4ε (|M x/s²|₂ + k max|x|) with k the root sum of squares of the
  /// elements' V (λ + 2μ) |∇N|². No solver can get below it.
  double residual_limit(const Vector& x, double tolerance) const;

 private:
  const MechanicalSystem& system_;
  double step_ = 0.0;
  Vector previous_;
  Vector target_;
  double force_scale_ = 0.0;
  double stiffness_scale_ = 0.0;  // k of residual_limit()
};

}  // namespace tetraction
