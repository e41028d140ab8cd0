// The implicit Hamilton–Pontryagin step as a minimisation.
#pragma once

#include "tetraction/dynamics/problems/potential_problem.h"

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
/// In the form of PotentialProblem, relative to q_k, so that Φ has no constant that grows with s,
///
///     k = m/s² + ∂²D/∂v²/s + ∂²U/∂x²,   l = p_k/s + f − ∇U(q_k).
///
/// l also contains the linear part at q_k of all other terms. The rest of these terms,
/// U(x) − U(q_k) − ∇U(q_k)·(x − q_k) and s D, is evaluated at every x. Dissipation potentials that depend
/// on positions are taken at dissipation_point(), which is known before the step.
/// The minimiser over the free coordinates gives v = (x − q_k)/s. Prescribed components keep their
/// values in the origin.
class StepProblem : public PotentialProblem {
 public:
  /// Keeps a reference to `system`, which must live longer.
  explicit StepProblem(const MechanicalSystem& system) : PotentialProblem(system) {}

  /// Sets up the step of size h from `state` to `end_time` under the loads f (3 per vertex, N;
  /// empty: none). The origin is at base(). Call it again after any change of the system.
  virtual void begin(const State& state, double h, double end_time, double alpha,
                     const Vector& load);

  /// s = αh, s.
  double step() const { return step_; }
  /// Sets the prescribed components of base() to the values that x would have if the step ended at
  /// `time`. With a time within the step they move a part of their way only, which the solver uses
  /// if they move far. begin() uses the end of the step.
  void prescribe_base(double time);
  /// x ← q_k + l/k, projected to what the constraints allow: the positions without elastic forces.
  void inertial_guess(Vector& x) const;

  /// Moves vertices of x so that the way of the step crosses no obstacle, as far as the constraints allow it.
  void clear_way(Vector& x) const;

  /// So it is for viscosity with the midpoint rule (ViscousPotential).
  bool needs_rate_estimate() const override { return alpha_ == 0.5 && viscous_.factor() != 0.0; }
  void set_rate_estimate(const Vector& u) override;
  /// Where dissipation potentials of terms are taken, 3 per vertex, m: for backward Euler at q_k, for the
  /// midpoint rule at q_k + s M⁻¹p_k, which keeps the order of the rule.
  const Vector& dissipation_point() const { return dissipation_point_; }
  /// The energy that dissipative terms and viscosity dissipate in the whole step of size h, J. It
  /// is h Σ v·∂D/∂v + h Σ V 2η|Ė|² with the rates at x, and never negative. Of a part, its share.
  double dissipated_energy(const Vector& u, double h) const;

  // force_scale() is |Tᵀ l|₂, N: the force that would give the body its momentum and the impulse of
  // the loads within s. For a body without constraints the momentum is that of the motion relative
  // to its centre of mass, so that a uniform velocity does not make the tolerance larger. It is 0 if
  // there are no loads and the momenta are mere round-off.

  /// 6 W s²/(m l²) with the elastic energy W, the mass m and the size l of an element. It compares s
  /// with the time in which a strut as thin as an element buckles under the stress σ = √(2EW/V): a
  /// bending wave of wave number k in a strut with the radius of gyration r has the frequency
  /// ω² = (E r² k⁴ − σ k²)/ρ ≥ −σ²/(4Eρr²), and l = √12 r.
  double buckling_ratio(const Vector& u) const override;

 private:
  double alpha_ = 1.0;
};

}  // namespace tetraction
