// The elements of a minimisation problem as residuals of Ceres: the shifted square root of
// tetraction/solver/ceres_minimizer.h.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>

#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// Residuals and Jacobian of one element at the point evaluated last. The residuals are
/// r₀ = √(2(E + cV)) and, for each coordinate of its nodes, one that is zero.
struct ElementResidual {
  bool defined = false;  ///< false where E is not
  double root = 0.0;     ///< r₀
  Matrix jacobian;       ///< row 0: ∂r₀; below: K
};

/// Evaluates all elements at once, in parallel, when Ceres has moved to a new point.
class ElementEvaluator : public ceres::EvaluationCallback {
 public:
  /// Keeps references to `system` and `y`. Ceres' parameter blocks point into `y`, which holds the
  /// free coordinates of the displacement from the first point of the solve.
  ElementEvaluator(const MechanicalSystem& system, const Vector& y);

  /// Begins a solve of `problem` at `x` with c = `shift_density`, J/m³.
  void begin(const MinimizationProblem& problem, const Vector& x, double shift_density);
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;
  const ElementResidual& element(Index e) const { return elements_[static_cast<std::size_t>(e)]; }

 private:
  void evaluate(Index e, bool with_jacobian);

  const MechanicalSystem& system_;
  const Vector& y_;
  Vector start_;                           // positions at y = 0
  Vector x_;                               // positions at y
  MinimizationProblem::TermShares terms_;  // of force terms at x_
  bool has_terms_ = false;
  std::vector<ElementResidual> elements_;
  const MinimizationProblem* problem_ = nullptr;
  std::vector<double> shifts_;  // of the energies of the elements, J
  bool has_residuals_ = false;
  bool has_jacobians_ = false;
};

/// Makes the cost function that gives element e of the evaluator to Ceres, and the list of the
/// first free coordinates of its parameter blocks. The caller owns the function. Returns null if
/// the element has no free coordinates.
ceres::CostFunction* make_element_cost(const ElementEvaluator& evaluator,
                                       const MechanicalSystem& system, Index e,
                                       std::vector<int>& blocks);

}  // namespace tetraction
