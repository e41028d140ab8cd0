#include "ceres_elements.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

// K with KᵀK = the positive semidefinite part of h.
Shape::DofMatrix square_root(const Shape::DofMatrix& h) {
  const Eigen::LLT<Shape::DofMatrix> cholesky(h);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Shape::DofMatrix> eigen(h);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

class ElementCost : public ceres::CostFunction {
 public:
  ElementCost(const ElementEvaluator& evaluator, Index element)
      : evaluator_(evaluator), element_(element) {
    set_num_residuals(ElementResidual::kRows);
    mutable_parameter_block_sizes()->assign(Shape::kNodes, 3);
  }

  bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
    constexpr int kRows = ElementResidual::kRows;
    const ElementResidual& result = evaluator_.element(element_);
    if (!result.defined) return false;
    std::fill(residuals, residuals + kRows, 0.0);
    residuals[0] = result.root;
    if (jacobians == nullptr) return true;
    for (int a = 0; a < Shape::kNodes; ++a) {
      if (jacobians[a] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>>{jacobians[a]} =
          result.jacobian.middleCols<3>(3 * a);
    }
    return true;
  }

 private:
  const ElementEvaluator& evaluator_;
  Index element_;
};

}  // namespace

ElementEvaluator::ElementEvaluator(const MechanicalSystem& system, const Vector& x)
    : system_(system), x_(x), elements_(static_cast<std::size_t>(system.rest().element_count())) {}

void ElementEvaluator::begin(const StepProblem& problem, double shift_density) {
  problem_ = &problem;
  shift_density_ = shift_density;
  has_residuals_ = has_jacobians_ = false;
}

void ElementEvaluator::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point) has_residuals_ = has_jacobians_ = false;
  if (evaluate_jacobians ? has_jacobians_ : has_residuals_) return;
  parallel_for(system_.rest().element_count(), 64, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) evaluate(e, evaluate_jacobians);
  });
  has_residuals_ = true;
  has_jacobians_ = evaluate_jacobians;
}

void ElementEvaluator::evaluate(Index e, bool with_jacobian) {
  ElementResidual& result = elements_[static_cast<std::size_t>(e)];
  ElasticPotential::ElementTerms terms;
  result.defined = problem_->element_terms(e, x_, with_jacobian, terms);
  if (!result.defined) return;
  const double shifted = terms.energy + shift_density_ * system_.rest().volume(e);
  result.defined = shifted > 0.0 && std::isfinite(shifted);
  if (!result.defined) return;
  result.root = std::sqrt(2.0 * shifted);
  if (!with_jacobian) return;
  const Eigen::Map<const Shape::DofVector> gradient(terms.gradient.data());
  result.jacobian.row(0) = gradient.transpose() / result.root;
  result.jacobian.bottomRows<ElementResidual::kDofs>() =
      square_root(terms.hessian - gradient * gradient.transpose() / (2.0 * shifted));
}

ceres::CostFunction* make_element_cost(const ElementEvaluator& evaluator, Index e) {
  return new ElementCost(evaluator, e);
}

}  // namespace tetraction
