// The common part of the potential of an implicit step and that of an equilibrium.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

class ConstraintPotential;
class FrictionStep;

/// A function of the positions x of a body, relative to a reference q:
///
///     Φ(x) = W(x) + ½ Σ_i k_i (x_i − q_i)² − Σ_i l_i (x_i − q_i)
///            + Σ w_U (U(x) − U(q) − ∇U(q)·(x − q)) + s Σ D((x − q)/s)
///
/// W is the elastic energy. U and D are the potentials and dissipation potentials of those force
/// terms that are not quadratic in single vertices (force_term.h); viscosity is one of the D. Each
/// potential has a weight w_U. The coefficients k ≥ 0 and the linear part l contain all the rest: the
/// quadratic terms, the gradients at q of all potentials, loads, and in a step the inertia. A derived
/// class sets them, and the reference.
///
/// The unknown is the displacement u from an origin o near the solution, x = o + u, because sums of
/// positions and small changes lose digits (fem/positions.h):
///
///     ½ Σ_i k_i (x_i − q_i)² − Σ_i l_i (x_i − q_i) = Φ_o + ½ Σ_i k_i u_i² − Σ_i r_i u_i,
///     r = l − k (o − q).
///
/// The potential U_c of contact with obstacles is added as it is, because it may be infinite at q, and
/// so is the dissipation potential of friction with normal forces that are known before
/// (contact/contact.h).
///
/// Prescribed components keep their values in the origin.
class PotentialProblem : public MinimizationProblem {
 public:
  using Shape = RestState::Shape;

  const MechanicalSystem& system() const { return system_; }
  /// The constraints whose equations hold at the solution.
  virtual const Constraints& constraints() const { return system_.constraints(); }
  /// q, but with the prescribed components at the values that they have in x.
  const Vector& base() const { return base_; }
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
  /// x − q = (o − q) + u. The reference is valid until the next call. Without viscosity nobody needs
  /// x − q, and u itself is returned.
  const Vector& step_displacement(const Vector& u) const;
  /// Sets the forces of constraints' equations, which are added to l (3 per vertex, N; empty: none).
  void set_constraint_force(const Vector& force);
  ~PotentialProblem() override;

  /// Adds the augmented Lagrangian's part of the constraints' equations to Φ (null: none). It must live as long
  /// as it is used, and its origin follows that of the problem.
  void set_constraint_potential(ConstraintPotential* potential);
  /// Lets solvers stop at residuals that are so many times larger, for a first approximation.
  void set_roughness(double roughness) { roughness_ = roughness; }
  double roughness() const { return roughness_; }

  /// Whether there is friction in this step, and the friction with the normal forces that Φ has.
  bool has_friction() const;
  const FrictionStep& friction() const { return *friction_; }
  /// Whether forces that have no potential depend on positions: such loads, and friction.
  bool has_following_forces() const { return system_.has_load_of_position() || has_friction(); }

  /// Loads that depend on positions are constant in Φ: w f₀ with a weight w. This is what is missing of the
  /// equations with the loads at x = o + u: residual += w (f₀ − f(x)).
  void add_load_deviation(const Vector& u, Vector& residual) const;
  /// stiffness ← −w ∂f/∂x at x = o + u.
  void load_stiffness(const Vector& u, LoadStiffness& stiffness) const;
  /// Replaces f₀ by the loads at x = o + u, and the normal forces of friction by those there.
  void take_loads(const Vector& u);
  /// Takes the normal forces of friction at x = o + u, which changes neither the equations with
  /// add_load_deviation() nor their solution, but brings the Hessian closer to their derivative.
  void take_friction(const Vector& u);
  /// f₀, 3 per vertex, N.
  const Vector& constant_loads() const { return constant_loads_; }
  /// Whether term_hessian() has the symmetric part of the stiffness of such loads, with which the Hessian is
  /// closer to the derivative of the equations than that of Φ.
  void set_with_load_stiffness(bool with) { with_load_stiffness_ = with; }

  /// k, per DOF, N/m.
  const Vector& coefficient() const { return coefficient_; }
  /// The dissipation potential of the viscosity; it is zero in an equilibrium.
  const ViscousPotential& viscous() const { return viscous_; }
  /// Whether Φ contains an estimate of the strain rate that must agree with the minimiser.
  virtual bool needs_rate_estimate() const { return false; }
  /// Sets the estimate to the strain rate at u.
  virtual void set_rate_estimate(const Vector& /*u*/) {}

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
  bool has_general_terms() const override {
    return !potentials_.empty() || !dissipations_.empty() || with_load_stiffness_ ||
           constraint_potential_ != nullptr || contact_ != nullptr || has_friction();
  }
  void term_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const override;
  bool term_shares(const Vector& u, bool with_hessian, TermShares& shares) const override;
  /// A vertex's part in an element is in proportion to the element's share of its lumped mass.
  bool element_terms(Index e, const Vector& u, const TermShares* terms, bool with_hessian,
                     ElasticPotential::ElementTerms& result) const override;
  /// The sum over the degrees of freedom of ½ r²/k, or of |r| times length_scale() where k is zero, J.
  /// With this constant the vertices' part of Φ is a sum of squares ½ k (u − r/k)², and of numbers
  /// that are positive as long as the body moves less than its size. The shares of elements contain
  /// both.
  double square_value() const override;

  double force_scale() const override { return roughness_ * force_scale_; }
  /// The estimate is
  ///
  ///     ½ε (|k u|₂ + |Tᵀl|₂ + K max|u| + K_L),
  ///
  /// K and K_L are the root sums of squares of the elements' C V |∇N|² and C V |∇N|² L, with
  /// C = λ + 2μ + 2η/s and the longest edge L. The terms with K and K_L stand for the round-off of
  /// displacements and of edges. Contact adds that of distances.
  double round_off(const Vector& u) const override;
  double dot(const Vector& a, const Vector& b) const override;
  double largest(const Vector& u) const override;
  double free_norm(const Vector& full) const override { return system_.restricted_norm(full); }

 protected:
  /// Keeps a reference to `system`, which must live longer.
  explicit PotentialProblem(const MechanicalSystem& system);

  /// Begins the setting of a problem with the reference q = `positions` and potentials at `time`, in a
  /// step or, without one, at this instant. The base is q. k and l must be set next.
  void begin_at(const Vector& positions, double time, const std::optional<TimeSpan>& step);
  /// Where terms are evaluated: at positions x, in this step.
  ForcePoint point(const Vector& x) const {
    ForcePoint at = system_.force_point(x, time_, span_);
    at.load_factor = load_factor_;
    return at;
  }
  /// Adds the potentials of all terms to k, l and the list of general terms. The weight is that of
  /// stored energies; potentials that stand for constraints have the weight 1.
  void gather_potentials(double weight);
  /// Adds the dissipation potentials at dissipation_point_ to k and the list of general terms.
  void gather_dissipations();
  /// Whether the potential of contact is a part of Φ. A rule that takes a mean force of it answers no, and
  /// adds it to its equations.
  virtual bool has_contact_potential() const { return true; }
  /// ∂q_{k+1}/∂x.
  virtual double rate_of_end() const { return 1.0; }
  /// The positions at the end of the step at o + u.
  virtual Vector end_positions(const Vector& u) const { return origin_ + u; }
  /// Begins the friction of a step.
  void begin_friction(double begin, double end, bool has_mean_forces);
  /// Finds |Tᵀl|₂. To be called when l is complete.
  void measure_load();

  /// The positions at which hessian_parts() and element_terms() take the elastic energy: x.
  virtual Positions elastic_positions(const Vector& u) const { return {origin_, u}; }
  const Vector& constraint_force() const { return constraint_force_; }
  /// residual ← k u − r minus the gradients at q of the potentials that are not quadratic, plus the
  /// gradients of the dissipation potentials: the parts of ∇Φ(o + u) that are neither elastic or
  /// viscous nor forces of these potentials at x. Returns false if a term is not defined at o + u.
  bool vertex_residual(const Vector& u, Vector& residual) const;
  /// Calls visit(term) for every term with a potential that is not quadratic.
  template <class Visit>
  void for_each_potential(const Visit& visit) const {
    for (const WeightedPotential& potential : potentials_) visit(*potential.term);
  }
  /// Whether the energy of element e is defined for J > 0 only.
  bool needs_volume(Index e) const;
  /// Says what loads f₀ (3 per vertex, N) l has, with which weight w, and that they are at the instant or in
  /// the step of point(). To be called when l is complete.
  void set_constant_loads(const Vector& loads, double weight) {
    constant_loads_ = loads;
    load_weight_ = weight;
  }
  /// l += `force` (3 per vertex, N). To be called before set_origin().
  void add_load(const Vector& force) { load_ += force; }

  const MechanicalSystem& system_;
  double volume_ = 0.0;
  ViscousPotential viscous_;
  Vector previous_;  // q
  Vector base_;
  Vector dissipation_point_;
  Vector coefficient_;  // k, per DOF
  Vector load_;         // l without the constraints' forces
  double step_ = 0.0;   // s
  double time_ = 0.0;   // of potentials
  double load_factor_ = 1.0;
  std::optional<TimeSpan> span_;
  double force_scale_ = 0.0;
  double roughness_ = 1.0;
  double load_norm_ = 0.0;  // |Tᵀ l|₂
  mutable Vector full_;     // work space
  mutable Vector velocity_;

 private:
  // A potential that is not quadratic.
  struct WeightedPotential {
    const ForceTerm* term;
    double weight;
  };

  // Sets at_ and velocity_ to the positions and velocities at u. Fails if a term is not defined
  // there.
  EvaluationStatus move_terms(const Vector& u) const;
  double longest_term_step(const Vector& u, const Vector& d) const;
  // Where energies are evaluated, of the own vertices of a part.
  ForcePoint energy_point(const Vector& x) const;
  double term_energy(const Vector& u) const;
  bool is_elastic_known(const Vector& u) const;
  void add_viscous(const Vector& u, double& phi, Vector& gradient) const;
  EvaluationStatus agree(EvaluationStatus status, double& phi) const;
  void add_term_gradient(const Vector& u, Vector& gradient) const;
  void add_gradient(const WeightedPotential& potential, const ForcePoint& at,
                    Vector& gradient) const;
  void add_diagonal(double factor);
  Index element_of(Index i, Index j) const;
  // Evaluates elastic_ at u, unless it is known there.
  EvaluationStatus evaluate_elastic(const Vector& u) const;
  void make_remainder();
  ForcePoint load_point(const Vector& x) const;

  Vector origin_;            // o
  Vector constraint_force_;  // empty: none
  ConstraintPotential* constraint_potential_ = nullptr;
  Vector remainder_;       // r
  Vector constant_loads_;  // f₀
  double load_weight_ = 1.0;
  bool with_load_stiffness_ = false;
  // Terms that are not quadratic, and the gradient of their potentials at q.
  std::vector<WeightedPotential> potentials_;
  std::vector<const ForceTerm*> dissipations_;
  Vector start_gradient_;
  const Contact* contact_ = nullptr;  // whose potential is a part of Φ; null: none
  std::unique_ptr<FrictionStep> friction_;
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
  mutable Vector at_;
  HessianBlocks blocks_;
  mutable HessianBlocks weighted_;
  mutable LoadStiffness load_stiffness_;
  mutable Vector weighted_gradient_;
  mutable std::map<std::array<Index, 2>, Index> element_of_edge_;  // made when first needed
  mutable Vector moved_;                                           // x − q
};

}  // namespace tetraction
