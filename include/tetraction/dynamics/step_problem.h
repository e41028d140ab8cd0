// The implicit Hamilton–Pontryagin step as a minimisation.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/nonlinear_problem.h"

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
class StepProblem : public MinimizationProblem {
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

  const FreeCoordinates& coordinates() const override { return system_.coordinates(); }
  /// The cube root of the body's volume, m.
  double length_scale() const override;

  /// phi = Φ(o + u) − Φ_o, J.
  EvaluationStatus value(const Vector& u, double& phi) const override;
  EvaluationStatus value_and_full_gradient(const Vector& u, double& phi,
                                           Vector& gradient) const override;
  /// energy = the elastic energy at o + u, J.
  EvaluationStatus elastic_energy(const Vector& u, double& energy) const;
  /// Sets `gradient` to the address of the gradient of the elastic energy at o + u (3 per vertex,
  /// N). It is valid until the next evaluation.
  EvaluationStatus elastic_gradient(const Vector& u, const Vector*& gradient) const;
  bool is_defined(const Vector& u) const override;
  /// The step is limited by admissible_step() (fem/step_length.h) over the elements whose energy is
  /// defined for J > 0 only (Saint Venant–Kirchhoff is defined for any J and may have to pass
  /// J = 0), and by nine tenths of the way to where a force term may not be defined.
  double longest_step(const Vector& u, const Vector& d, bool elements_are_safe) const override;

  HessianParts hessian_parts(const Vector& u) const override;
  /// General force terms are those that are not quadratic in single vertices.
  bool has_general_terms() const override { return !potentials_.empty() || !dissipations_.empty(); }
  void term_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const override;
  bool term_shares(const Vector& u, bool with_hessian, TermShares& shares) const override;
  /// A vertex's part in an element is in proportion to the element's share of its lumped mass.
  bool element_terms(Index e, const Vector& u, const TermShares* terms, bool with_hessian,
                     ElasticPotential::ElementTerms& result) const override;
  /// ½ Σ r²/k, J. With this constant the vertices' part of Φ is a sum of squares ½ k (u − r/k)²,
  /// which the shares of elements contain.
  double square_value() const override;

  /// |Tᵀ l|₂, N: the force that would give the body its momentum and the impulse of the loads
  /// within s. For a body without constraints the momentum is that of the motion relative to its
  /// centre of mass, so that a uniform velocity does not make the tolerance larger. It is 0 if there
  /// are no loads and the momenta are mere round-off.
  double force_scale() const override { return force_scale_; }
  /// The estimate is
  ///
  ///     ½ε (|k u|₂ + |Tᵀl|₂ + K max|u| + K_L),
  ///
  /// K and K_L are the root sums of squares of the elements' C V |∇N|² and C V |∇N|² L, with
  /// C = λ + 2μ + 2η/s and the longest edge L. The terms with K and K_L stand for the round-off of
  /// displacements and of edges.
  double round_off(const Vector& u) const override;
  /// 6 W s²/(m l²) with the elastic energy W, the mass m and the size l of an element. It compares s
  /// with the time in which a strut as thin as an element buckles under the stress σ = √(2EW/V): a
  /// bending wave of wave number k in a strut with the radius of gyration r has the frequency
  /// ω² = (E r² k⁴ − σ k²)/ρ ≥ −σ²/(4Eρr²), and l = √12 r.
  double buckling_ratio(const Vector& u) const override;

 private:
  void gather_terms();
  // Where terms are evaluated: at positions x, in this step.
  ForcePoint point(const Vector& x) const { return system_.force_point(x, time_, span_); }
  // x − q_k at u.
  Vector3 way(const Vector& u, Index v) const {
    return (vertex_block(origin_, v) - vertex_block(previous_, v)) + vertex_block(u, v);
  }
  // Sets at_ and velocity_ to the positions and velocities at u. Fails if a term is not defined
  // there.
  EvaluationStatus move_terms(const Vector& u) const;
  double longest_term_step(const Vector& u, const Vector& d) const;
  double term_energy() const;
  void add_term_gradient(Vector& gradient) const;
  Index element_of(Index i, Index j) const;
  // Evaluates elastic_ at u, unless it is known there.
  EvaluationStatus evaluate_elastic(const Vector& u) const;
  void make_remainder();

  const MechanicalSystem& system_;
  double volume_ = 0.0;  // of the body, m³
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
  TimeSpan span_;       // that of the step
  // Terms that are not quadratic, and the gradient of their potentials at q_k.
  std::vector<const ForceTerm*> potentials_;
  std::vector<const ForceTerm*> dissipations_;
  Vector start_gradient_;
  double force_scale_ = 0.0;
  double load_norm_ = 0.0;  // |Tᵀ l|₂
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
  mutable std::map<std::array<Index, 2>, Index> element_of_edge_;  // made when first needed
  mutable Vector moved_;                                           // x − q_k
};

}  // namespace tetraction
