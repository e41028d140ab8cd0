// The implicit Hamilton–Pontryagin step as a minimisation.
#pragma once

#include <vector>

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The incremental potential Φ of one implicit step. Its variable is the point x = q_k + s v where
/// the force is evaluated, with s = αh (α = ½: midpoint, α = 1: backward Euler):
///
///     Φ(x) = 1/(2s²) |x − q_k − s M⁻¹(p_k + s f)|²_M + W(x) + Σ U(x) + s Σ D((x − q_k)/s)
///
/// (Kharevych et al. 2006, the Pontryagin–d'Alembert functional). W is the elastic energy. U, D and
/// f are the potentials, dissipation potentials and loads of the system's force terms
/// (force_term.h); viscosity is one of the D. Potentials that depend on the time are evaluated at
/// t_k + s.
///
/// The unknown is the displacement u from an origin o near the solution, x = o + u, because sums of
/// positions and small changes lose digits (fem/positions.h). Terms that are quadratic in single
/// vertices are combined into one. Φ is written relative to q_k, so that it has no constant that
/// grows with s:
///
///     ½ Σ_i k_i (x_i − q_i)² − Σ_i l_i (x_i − q_i) = Φ_o + ½ Σ_i k_i u_i² − Σ_i r_i u_i,
///     k = m/s² + ∂²D/∂v²/s + ∂²U/∂x²,   l = p_k/s + f − ∇U(q_k),   r = l − k (o − q_k).
///
/// l also contains the linear part at q_k of all other terms. The rest of these terms,
/// U(x) − U(q_k) − ∇U(q_k)·(x − q_k) and s D, is evaluated at every x. Dissipation potentials that depend
/// on positions are taken at dissipation_point(), which is known before the step.
/// The minimiser over the free coordinates gives v = (x − q_k)/s. Prescribed components keep their
/// values in the origin.
class StepProblem {
 public:
  using Shape = RestState::Shape;

  /// Keeps a reference to `system`, which must live longer.
  explicit StepProblem(const MechanicalSystem& system);

  /// Sets up the step of size h from `state` to `end_time` under the loads f (3 per vertex, N;
  /// empty: none). The origin is at base(). Call it again after any change of the system.
  void begin(const State& state, double h, double end_time, double alpha, const Vector& load);
  /// Adds constraint impulses to p_k (3 per vertex, N s) for the same step.
  void set_impulse(const Vector& impulse);

  const MechanicalSystem& system() const { return system_; }
  /// s = αh, s.
  double step() const { return step_; }
  /// q_k, but with the prescribed components at the values that they have in x.
  const Vector& base() const { return base_; }
  /// Sets the prescribed components of base() to the values that x would have if the step ended at
  /// `time`. With a time within the step they move a part of their way only, which the solver uses
  /// if they move far. begin() uses the end of the step.
  void prescribe_base(double time);
  /// o ← `positions`, whose prescribed components must be those of base().
  void set_origin(const Vector& positions);
  const Vector& origin() const { return origin_; }
  /// Moves the origin to o + u, rounded, and returns the rounding error in u.
  void move_origin(Vector& u);
  /// Φ_o, J, the constant that value() omits. With it values with different origins can be
  /// compared.
  double origin_value() const;
  /// x = o + u.
  void positions(const Vector& u, Vector& x) const { x = origin_ + u; }
  /// x − q_k = (o − q_k) + u. The reference is valid until the next call. Without viscosity nobody
  /// needs x − q_k, and u itself is returned.
  const Vector& step_displacement(const Vector& u) const;
  /// x ← q_k + l/k, projected to what the constraints allow: the positions without elastic forces.
  void inertial_guess(Vector& x) const;

  /// k, per DOF, N/m.
  const Vector& coefficient() const { return coefficient_; }
  /// The dissipation potential of the viscosity in this step.
  const ViscousPotential& viscous() const { return viscous_; }
  /// Whether Φ contains an estimate of the strain rate that must agree with the minimiser. This is
  /// so for viscosity with the midpoint rule (ViscousPotential).
  bool needs_rate_estimate() const { return alpha_ == 0.5 && viscous_.factor() != 0.0; }
  /// Sets the estimate to the strain rate at u.
  void set_rate_estimate(const Vector& u);
  /// Where dissipation potentials of terms are taken, 3 per vertex, m: for backward Euler at q_k, for the
  /// midpoint rule at q_k + s M⁻¹p_k, which keeps the order of the rule.
  const Vector& dissipation_point() const { return dissipation_point_; }
  /// The energy that dissipative terms and viscosity dissipate in the whole step of size h, J. It
  /// is h Σ v·∂D/∂v + h Σ V 2η|Ė|² with the rates at x, and never negative.
  double dissipated_energy(const Vector& u, double h) const;

  /// phi = Φ(o + u) − Φ_o, J.
  EvaluationStatus value(const Vector& u, double& phi) const;
  /// gradient = Tᵀ∇Φ over the free coordinates, N.
  EvaluationStatus value_and_gradient(const Vector& u, double& phi, Vector& gradient) const;
  /// gradient = ∇Φ, 3 per vertex, N.
  EvaluationStatus value_and_full_gradient(const Vector& u, double& phi, Vector& gradient) const;
  /// energy = the elastic energy at o + u, J.
  EvaluationStatus elastic_energy(const Vector& u, double& energy) const;
  /// Sets `gradient` to the address of the gradient of the elastic energy at o + u (3 per vertex,
  /// N). It is valid until the next evaluation.
  EvaluationStatus elastic_gradient(const Vector& u, const Vector*& gradient) const;
  /// Whether there are force terms that are not quadratic in single vertices.
  bool has_general_terms() const { return !potentials_.empty() || !dissipations_.empty(); }
  /// hessian = the contribution of these terms to ∇²Φ at o + u, N/m; zero if there are none.
  void term_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const;
  /// The largest t up to which the potentials of all terms are known to be defined from o + u to
  /// o + u + t d; infinite where there is no limit.
  double longest_term_step(const Vector& u, const Vector& d) const;
  /// Whether Φ is defined at o + u.
  bool is_defined(const Vector& u) const;
  /// values = Tᵀ∇²Φ T in the pattern's order, N/m, with `terms` from term_hessian(). The pattern
  /// must have the pairs of `terms`.
  EvaluationStatus hessian(const Vector& u, const HessianBlocks& terms,
                           const SparsityPattern& pattern, double* values) const;
  /// The contribution to Φ of the terms that are not quadratic, for sums over elements.
  struct TermShares {
    double energy = 0.0;     ///< J
    double magnitude = 0.0;  ///< how far `energy` can get below zero is of this order, J
    Vector gradient;         ///< 3 per vertex, N
    HessianBlocks hessian;   ///< of evaluations with a Hessian
  };
  /// Evaluates this contribution at o + u. Returns false if a term is not defined there.
  bool term_shares(const Vector& u, bool with_hessian, TermShares& shares) const;
  /// The share of element e in Φ. It consists of the elastic and viscous energy of the element and
  /// of a part of the energies of its vertices, in proportion to the element's share of their
  /// lumped mass. `terms` may be null if there are no such terms. Only the diagonal blocks of their
  /// Hessians enter. The shares of all elements add up to value() + square_value().
  bool element_terms(Index e, const Vector& u, const TermShares* terms, bool with_hessian,
                     ElasticPotential::ElementTerms& result) const;
  /// ½ Σ r²/k, J. With this constant the vertices' part of Φ is a sum of squares ½ k (u − r/k)²,
  /// which the shares of elements contain.
  double square_value() const;

  /// |Tᵀ l|₂, N: the force that would give the body its momentum and the impulse of the loads
  /// within s. It is 0 if there are no loads and the momenta are mere round-off. Tolerances are
  /// relative to it.
  double force_scale() const { return force_scale_; }
  /// An estimate of the round-off of |Tᵀ∇Φ|₂ at u in double precision, N:
  ///
  ///     ½ε (|k u|₂ + |Tᵀl|₂ + K max|u| + K_L),
  ///
  /// K and K_L are the root sums of squares of the elements' C V |∇N|² and C V |∇N|² L, with
  /// C = λ + 2μ + 2η/s and the longest edge L. The terms with K and K_L stand for the round-off of
  /// displacements and of edges. No solver can get far below this residual.
  double round_off(const Vector& u) const;
  /// Whether the force scale is above a thousandth of round_off(). If so, a first guess must not be
  /// accepted because its residual is below round_off(): the load itself may be smaller than that.
  bool is_loaded(const Vector& u) const { return force_scale_ > 1e-3 * round_off(u); }
  /// Largest |Tᵀ∇Φ|₂ that counts as converged, N: max(tolerance × force scale, round_off()).
  double residual_limit(const Vector& u, double tolerance) const;

 private:
  void gather_terms();
  // x − q_k at u.
  Vector3 way(const Vector& u, Index v) const {
    return (vertex_block(origin_, v) - vertex_block(previous_, v)) + vertex_block(u, v);
  }
  // Sets at_ and velocity_ to the positions and velocities at u. Fails if a term is not defined
  // there.
  EvaluationStatus move_terms(const Vector& u) const;
  double term_energy() const;
  void add_term_gradient(Vector& gradient) const;
  // Evaluates elastic_ at u, unless it is known there.
  EvaluationStatus evaluate_elastic(const Vector& u) const;
  void make_remainder();

  const MechanicalSystem& system_;
  ViscousPotential viscous_;
  double step_ = 0.0;
  double alpha_ = 1.0;
  Vector previous_;  // q_k
  Vector dissipation_point_;
  Vector base_;
  Vector origin_;
  Vector load_;         // l without constraint impulses
  Vector impulse_;      // of constraints; empty: none
  Vector coefficient_;  // k, per DOF
  Vector remainder_;    // r
  double time_ = 0.0;   // of potentials
  // Terms that are not quadratic, and the gradient of their potentials at q_k.
  std::vector<const ForceTerm*> potentials_;
  std::vector<const ForceTerm*> dissipations_;
  Vector start_gradient_;
  double force_scale_ = 0.0;
  // The elastic part of the last evaluation with a gradient. It is kept because the last evaluation
  // of a minimiser is at the point that the momenta are taken from, and its first one is often at
  // the best guess.
  struct ElasticPart {
    bool known = false;
    Vector u;
    double energy = 0.0;
    Vector gradient;
  };
  mutable ElasticPart elastic_;
  mutable Vector full_;  // work space
  mutable Vector at_;
  mutable Vector velocity_;
  HessianBlocks blocks_;
  mutable Vector moved_;  // x − q_k
};

}  // namespace tetraction
