// The equilibrium of a body as a minimisation.
#pragma once

#include "tetraction/dynamics/energies.h"
#include "tetraction/dynamics/problems/potential_problem.h"

namespace tetraction {

/// The potential Π of a body at rest under a share φ of its loads, the load factor:
///
///     Π(x) = W(x) + φ Σ U(x) − φ f·x + Σ U_c(x; φ)
///
/// W is the elastic energy. U are the stored potentials of the system's force terms and f their
/// loads, both at one time t. U_c are the potentials that stand for constraints (penalty springs).
/// They keep their stiffness, and their force at rest X is scaled:
/// U_c(x; φ) = U_c(x) − (1 − φ) ∇U_c(X)·x, which moves the targets of springs from X to where they
/// are at t. Prescribed components have the values X + φ (target − X), and a distance the length
/// L_X + φ (L − L_X) with its length L_X in the undeformed body. Dissipation has no part in an
/// equilibrium.
///
/// A minimiser over the free coordinates is a stable equilibrium. In the form of PotentialProblem,
/// relative to positions q near it, k = ∂²U_c/∂x² + φ ∂²U/∂x² of quadratic terms, and l is minus the
/// gradient at q of all but W.
class StaticProblem : public PotentialProblem {
 public:
  /// Potentials, loads and targets are those at the instant `time`, s. Keeps a reference to `system`, which must
  /// live longer. Make a new problem after the constraints were changed.
  StaticProblem(const MechanicalSystem& system, double time);

  /// Sets up the equilibrium under the load factor φ = `factor`, 0 ≤ φ ≤ 1, near positions q (3 per
  /// vertex, m). The origin is at base(). Loads that depend on positions are those at q.
  void begin(const Vector& q, double factor) { begin(q, factor, load(q)); }
  /// The same with these loads (3 per vertex, N).
  void begin(const Vector& q, double factor, const Vector& load);

  /// The time of potentials, loads and targets, s.
  double time() const { return time_; }
  /// The loads f at positions x, 3 per vertex, N.
  Vector load(const Vector& x) const;
  /// The load on the body at a load factor and positions x: loads, and the forces of
  /// potentials that count as external work (3 per vertex, N).
  Vector applied_force(double factor, const Vector& x) const;
  /// The constraints with the lengths of the last begin().
  const Constraints& constraints() const override { return constraints_; }
  /// Sets the prescribed components of x to their values at a load factor.
  void prescribe(double factor, Vector& x) const;
  /// The largest deviation of x from the constraints at a load factor, m.
  double constraint_error(double factor, const Vector& x) const;
  /// The forces of the constraints, 3 per vertex, N, at a displacement u from the origin that is a
  /// minimiser under the forces `equation_force` of the constraints' equations (3 per vertex, N; empty:
  /// none). What the minimiser left of the gradient along the free coordinates is no reaction.
  EvaluationStatus reactions(const Vector& u, const Vector& equation_force, Vector& reaction) const;
  /// The energies at x, J: none is kinetic; stored energies of force terms are multiplied by the load
  /// factor.
  EvaluationStatus energies(double factor, const Vector& x, Energies& energies) const;

  /// Says that the Hessian at the solution need not be examined again, as after a solve that did.
  void set_examined(bool examined) { examined_ = examined; }
  /// Says that the load step will be tried in parts if no solution is found, so that a solver need not search for
  /// long.
  void set_divisible(bool divisible) { divisible_ = divisible; }
  bool is_divisible() const { return divisible_; }
  /// Infinite, unless the Hessian need not be examined: no inertia keeps the body from buckling.
  double buckling_ratio(const Vector& u) const override;
  bool has_inertia() const override { return false; }

 private:
  Vector constraint_gradient(const Vector& x) const;
  void set_lengths(double factor, Constraints& constraints) const;

  Constraints constraints_;
  double factor_ = 1.0;
  bool examined_ = false;
  bool divisible_ = false;
  std::vector<double> rest_lengths_;  // of distances
  Vector rest_way_;                   // from X to the targets
  Vector rest_gradient_;              // ∇U_c(X)
};

}  // namespace tetraction
