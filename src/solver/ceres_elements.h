// The elements of a step problem as residuals of Ceres: the shifted square root of
// tetraction/solver/ceres_minimizer.h.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>

#include <vector>

#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// Residuals and Jacobian of one element at the point evaluated last: r₀ = √(2(E + cV)) and twelve
/// residuals that are zero.
struct ElementResidual {
  static constexpr int kDofs = RestState::Shape::kDofs;
  static constexpr int kRows = kDofs + 1;

  bool defined = false;                          ///< false where E is not
  double root = 0.0;                             ///< r₀
  Eigen::Matrix<double, kRows, kDofs> jacobian;  ///< row 0: ∂r₀; below: K
};

/// Evaluates all elements at once, in parallel, when Ceres has moved to a new point.
class ElementEvaluator : public ceres::EvaluationCallback {
 public:
  /// Keeps references; `x` is what Ceres' parameter blocks point into.
  ElementEvaluator(const MechanicalSystem& system, const Vector& x);

  /// Begins a solve of `problem` with c = `shift_density`, J/m³.
  void begin(const StepProblem& problem, double shift_density);
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;
  const ElementResidual& element(Index e) const { return elements_[static_cast<std::size_t>(e)]; }

 private:
  void evaluate(Index e, bool with_jacobian);

  const MechanicalSystem& system_;
  const Vector& x_;
  std::vector<ElementResidual> elements_;
  const StepProblem* problem_ = nullptr;
  double shift_density_ = 0.0;
  bool has_residuals_ = false;
  bool has_jacobians_ = false;
};

/// The cost function that hands element e of the evaluator to Ceres; the caller owns it.
ceres::CostFunction* make_element_cost(const ElementEvaluator& evaluator, Index e);

}  // namespace tetraction
