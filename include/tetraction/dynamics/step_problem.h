// The implicit Hamilton–Pontryagin step as a minimisation.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The incremental potential of one implicit step, written in the point x = q_k + s v where the
/// force is evaluated, with s = αh (α = ½: midpoint, α = 1: backward Euler):
///
///     Φ(x) = 1/(2s²) |x − q_k − s M⁻¹(p_k + s f)|²_M + W(x) + s D((x − q_k)/s) + Σ γ|x − c|²
///
/// (Kharevych et al. 2006, the Pontryagin–d'Alembert functional), with W = elastic energy +
/// environment, the dissipation potential D of drag, mass damping and viscosity, and the penalty
/// springs. Everything that is quadratic in single vertices is gathered into
///
///     ½ Σ_i k_i (x_i − x̂_i)²,   k = m/s² + (k_D + a m)/s + 2γ,
///
/// with the linear part of the environment at q_k in x̂; for a uniform environment that is all of it.
/// The minimiser over the free coordinates gives v = (x − q_k)/s. Prescribed components stay where
/// base() has them.
class StepProblem {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `system`, which must live longer.
  explicit StepProblem(const MechanicalSystem& system);

  /// Sets up the step of size h from `state` to `end_time` under the user forces f (3 per vertex,
  /// N; empty: none). To be called again after any change of the system.
  void begin(const State& state, double h, double end_time, double alpha, const Vector& user_force);
  /// Adds constraint impulses to p_k (3 per vertex, N s) for the same step.
  void set_impulse(const Vector& impulse);

  const MechanicalSystem& system() const { return system_; }
  /// s = αh, s.
  double step() const { return step_; }
  /// q_k, with the prescribed components where they are at x.
  const Vector& base() const { return base_; }
  /// x = x̂, less what the constraints do not allow: where the vertices would go without elastic
  /// forces.
  void inertial_guess(Vector& x) const;

  /// k, per DOF, N/m.
  const Vector& coefficient() const { return coefficient_; }
  /// The dissipation potential of the viscosity in this step.
  const ViscousPotential& viscous() const { return viscous_; }

  /// phi = Φ(x), J.
  Evaluation value(const Vector& x, double& phi) const;
  /// gradient = Tᵀ∇Φ(x) over the free coordinates, N.
  Evaluation value_and_gradient(const Vector& x, double& phi, Vector& gradient) const;
  /// gradient = ∇Φ(x), 3 per vertex, N.
  Evaluation value_and_full_gradient(const Vector& x, double& phi, Vector& gradient) const;
  /// energy = the elastic energy at x, J.
  Evaluation elastic_energy(const Vector& x, double& energy) const;
  /// gradient points to the gradient of the elastic energy at x (3 per vertex, N) until the next
  /// evaluation.
  Evaluation elastic_gradient(const Vector& x, const Vector*& gradient) const;
  /// values = Tᵀ∇²Φ(x)T in the pattern's order, N/m.
  Evaluation hessian(const Vector& x, const SparsityPattern& pattern, double* values) const;
  /// The share of element e in Φ: its elastic and viscous energy and its part of what belongs to its
  /// vertices, in proportion to their lumped mass. The shares add up to Φ.
  bool element_terms(Index e, const Vector& x, bool with_hessian,
                     ElasticPotential::ElementTerms& terms) const;

  /// The share of element e in the environment's energy at x, taken positive, J: how far the shares
  /// of element_terms() can get below zero is of this order. 0 for uniform environments.
  double environment_share(Index e, const Vector& x) const;

  /// Largest |Tᵀ∇Φ|₂ that counts as converged, N: max(tolerance × force scale, round-off).
  /// The force scale of a step is |Tᵀ(p_k/s + f − ∇U(q_k) + springs)|₂: the force that would give
  /// the body its momentum and the impulse of the loads within s. Round-off is what double precision
  /// leaves of positions: 4ε (|k x|₂ + K max|x|) with K the root sum of squares of the elements'
  /// V (λ + 2μ + 2η/s) |∇N|². No solver can get below it.
  double residual_limit(const Vector& x, double tolerance) const;

 private:
  void make_target();
  // Brings elastic_ to x.
  Evaluation evaluate_elastic(const Vector& x) const;

  const MechanicalSystem& system_;
  ViscousPotential viscous_;
  double step_ = 0.0;
  Vector previous_;  // q_k
  Vector base_;
  Vector load_;         // p_k/s + f − ∇U(q_k) + 2γ(c − q_k), without constraint impulses
  Vector impulse_;      // of constraints; empty: none
  Vector coefficient_;  // k, per DOF
  Vector target_;       // x̂
  bool curved_environment_ = false;
  double force_scale_ = 0.0;
  // The elastic part of the last evaluation with a gradient: a minimiser's last one is at the point
  // that the momenta are taken from, its first one often at the best guess.
  struct ElasticPart {
    bool known = false;
    Vector x;
    double energy = 0.0;
    Vector gradient;
  };
  mutable ElasticPart elastic_;
  mutable Vector full_;  // work space
};

}  // namespace tetraction
