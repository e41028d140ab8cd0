// The equations of an energy-momentum step.
#pragma once

#include "fem/discrete_gradient.h"
#include "tetraction/dynamics/problems/step_problem.h"

namespace tetraction {

/// Where the forces of an implicit step with the unknown (q_k + q_{k+1})/2 are taken.
enum class StepForces {
  kDiscrete,         ///< all from discrete gradients over the step
  kMiddleButContact  ///< at the middle, but contact from discrete gradients
};

/// The midpoint step with the same unknown x = (q_k + q_{k+1})/2, and the equations of the
/// energy-momentum step in the form of its gradient. With s = h/2,
///
///     r(x) = M (x − q_k)/s² − p_k/s − f + f̄_W + Σ f̄_U + ∂D/∂v((x − q_k)/s),
///
/// where f̄ are discrete gradients over the whole step (fem/discrete_gradient.h,
/// ForceTerm::add_discrete_gradient()) in the place of gradients at x. All coefficients, loads and
/// scales are those of the midpoint step. Its Hessian is close to ∂r/∂x and serves as the
/// preconditioner.
///
/// Contact with obstacles has a discrete gradient with both kinds of forces. The step of the midpoint rule with contact
/// has kMiddleButContact: a potential at x alone would let q_{k+1} pass an obstacle.
class DiscreteGradientStep : public StepProblem {
 public:
  /// Keeps a reference to `system`, which must live longer.
  DiscreteGradientStep(const MechanicalSystem& system, StepForces forces);

  StepForces forces() const { return forces_; }

  void begin(const State& state, double h, double end_time, double alpha,
             const Vector& load) override;
  EvaluationStatus conserving_residual(const Vector& u, Vector& residual) const;
  /// Whether the energies are defined at the end of the step.
  bool ends_defined(const Vector& u) const;
  /// The longest step before an element is inverted at the end of the step, or before nine tenths of
  /// the way to where a force term is not defined.
  double longest_step_of_end(const Vector& u, const Vector& d) const;
  /// Linearises r at u for multiply() and chooses where the Hessian is evaluated.
  void linearize(const Vector& u);
  /// The Hessian of Φ with that of the discrete gradient of contact.
  void term_hessian(const Vector& u, HessianForm form, HessianBlocks& hessian) const override;
  bool has_general_terms() const override {
    return StepProblem::has_general_terms() || system_.contact() != nullptr;
  }
  double round_off(const Vector& u) const override;
  /// Lets the Hessian be that of the midpoint step, until the next linearize().
  void take_hessian_at_middle() { at_end_ = false; }
  /// product = (∂r/∂u) d, except that ∂²U/∂x² at x stands for the derivatives of the f̄_U.
  void multiply(const Vector& d, Vector& product) const;
  /// Sets `gradient` to the address of f̄_W with its viscous part (3 per vertex, N). It is valid until
  /// the next evaluation.
  EvaluationStatus internal_gradient(const Vector& u, const Vector*& gradient) const;

  /// The ends of the step, for terms. The second refers to `end`.
  ForcePoint start_point() const { return {system_.mass(), previous_, start_time_}; }
  ForcePoint end_point(const Vector& end) const { return {system_.mass(), end, end_time_}; }

 protected:
  Positions elastic_positions(const Vector& u) const override;
  bool has_contact_potential() const override { return false; }
  double rate_of_end() const override { return 2.0; }
  Vector end_positions(const Vector& u) const override;

 private:
  // half_step_ ← x − q_k, end_ ← q_{k+1}.
  void move(const Vector& u) const;
  // Evaluates internal_ after move(), unless it is known there.
  EvaluationStatus evaluate_internal(const Vector& u) const;
  bool terms_are_defined(const Vector& u) const;
  EvaluationStatus add_internal(const Vector& u, Vector& gradient) const;
  void add_viscous_share(const Vector& u, Vector& gradient) const;
  void add_contact_hessian(const Vector& u, HessianForm form, bool symmetric,
                           HessianBlocks& hessian) const;
  // Whether the Hessian at x, after move(), would be a bad approximation.
  bool is_far_from_middle() const;

  StepForces forces_;
  DiscreteGradient gradient_;
  double start_time_ = 0.0;
  double end_time_ = 0.0;
  mutable Vector half_step_;
  mutable Vector end_;
  mutable Vector shift_;
  // The last evaluation of f̄_W. It is kept because the last one of a solver is at the solution.
  struct Internal {
    bool known = false;
    Vector half_step;
    Vector gradient;
  };
  mutable Internal internal_;
  Vector point_;            // u of the linearisation
  Vector point_half_step_;  // x − q_k there
  bool at_end_ = false;     // the Hessian is that at q_{k+1}
  HessianBlocks terms_;
  mutable HessianBlocks contact_blocks_;
  LoadStiffness load_stiffness_;
};

/// These equations for a RootFinder.
class EnergyMomentumProblem : public RootProblem {
 public:
  /// Keeps a reference to `step`, which must live longer.
  explicit EnergyMomentumProblem(DiscreteGradientStep& step) : step_(step) {}

  /// Multiplies the force scale and so the residual that counts as converged; 1 at first.
  void set_accuracy(double factor) { accuracy_ = factor; }

  const FreeCoordinates& coordinates() const override { return step_.coordinates(); }
  double length_scale() const override { return step_.length_scale(); }
  bool is_defined(const Vector& u) const override { return step_.ends_defined(u); }
  EvaluationStatus residual(const Vector& u, Vector& residual) const override {
    return step_.conserving_residual(u, residual);
  }
  double longest_step(const Vector& u, const Vector& d, bool) const override {
    return step_.longest_step_of_end(u, d);
  }
  double force_scale() const override { return accuracy_ * step_.force_scale(); }
  double round_off(const Vector& u) const override { return step_.round_off(u); }
  EvaluationStatus linearize(const Vector& u) override {
    step_.linearize(u);
    return {};
  }
  void multiply(const Vector& d, Vector& product) const override { step_.multiply(d, product); }
  const MinimizationProblem& approximation() const override { return step_; }

 private:
  DiscreteGradientStep& step_;
  double accuracy_ = 1.0;
};

}  // namespace tetraction
