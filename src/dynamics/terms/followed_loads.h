// The equations of a step or an equilibrium under loads that depend on positions.
#pragma once

#include <memory>

#include "fem/tangent_operator.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/potential_problem.h"

namespace tetraction {

/// stiffness += −∂f/∂x of the loads f that depend on positions.
void add_stiffness_of_loads(const MechanicalSystem& system, const ForcePoint& at,
                            LoadStiffness& stiffness);

/// ∇Φ(u) + w (f₀ − f(o + u)) = 0: the equations of a PotentialProblem whose loads f depend on positions
/// (PotentialProblem::add_load_deviation()). Their derivative is ∇²Φ − w ∂f/∂x.
class FollowedLoads : public RootProblem {
 public:
  /// Keeps a reference to `problem`, which must live longer.
  explicit FollowedLoads(PotentialProblem& problem) : problem_(problem) {}

  const FreeCoordinates& coordinates() const override { return problem_.coordinates(); }
  double length_scale() const override { return problem_.length_scale(); }
  bool is_defined(const Vector& u) const override { return problem_.is_defined(u); }
  EvaluationStatus residual(const Vector& u, Vector& residual) const override;
  double longest_step(const Vector& u, const Vector& d, bool elements_are_safe) const override {
    return problem_.longest_step(u, d, elements_are_safe);
  }
  double force_scale() const override { return problem_.force_scale(); }
  double round_off(const Vector& u) const override { return problem_.round_off(u); }
  EvaluationStatus linearize(const Vector& u) override;
  void multiply(const Vector& d, Vector& product) const override;
  const MinimizationProblem& approximation() const override { return problem_; }

 private:
  // product += the derivative of elastic and viscous forces at the point of the linearisation, times d.
  void add_stiffness_product(const Vector& d, Vector& product) const;
  void add_viscous_product(const Vector& d, Vector& product) const;

  PotentialProblem& problem_;
  Vector point_;                                              // u of the linearisation
  mutable std::unique_ptr<TangentOperator<double>> tangent_;  // made when first needed
  mutable bool knows_tangent_ = false;                        // whether it is linearised at point_
  mutable AlignedVector<double> records_;
  HessianBlocks terms_;
  LoadStiffness stiffness_;
  mutable Vector elastic_;  // work space
  mutable Vector position_;
};

}  // namespace tetraction
